"""Tunings of random levels against their closed forms: what is said of goals, and 300 random points.

    first = k a b + c, second = a^2 - m b + d, with a and b free and k within a tolerance

`python -m tests.runner.design.tune.test_random_tunings FIRST LAST` prints those that are wrong.
"""

import itertools
import math
import random
import sys
from typing import Any

import numpy as np
import pytest

from proofmass import Graph, tune
from proofmass.blocks import Constant, Difference, Gain, Product, Step, Sum
from proofmass.runner.design.tune.tune import Tuned

NEAR = 2e-3  # of the range of a value, that a random point may be better
POINTS = 300


class Levels:
    """A graph, what is wanted of it, and its closed form."""

    def __init__(self, number: int) -> None:
        dice = random.Random(number)
        size = 10.0 ** dice.choice([-9, -3, 0, 0, 3])  # of what comes out
        self.k, self.c, self.m, self.d = (dice.uniform(-2.0, 2.0) for _ in range(4))
        self.size, self.part = size, dice.choice([0.0, 0.1, 0.3])
        self.ends = {name: self._ends(dice) for name in "ab"}
        self.begin = {name: dice.uniform(*ends) for name, ends in self.ends.items()}
        self.goals: dict[str, dict[str, Any]] = {"first": self._goal(dice, 0), "second": self._goal(dice, 1)}

    @staticmethod
    def _ends(dice: random.Random) -> tuple[float, float]:
        low = dice.uniform(-2.0, 1.0)
        return low, low + dice.uniform(0.5, 3.0)

    def _goal(self, dice: random.Random, place: int) -> dict[str, Any]:
        match dice.randint(0, 5):
            case 0:
                return {"minimise": True}
            case 1:
                return {"maximise": True}
            case 2:
                return {dice.choice(["at_least", "at_most"]): 0.0}
            case 3:
                return {dice.choice(["at_least", "at_most"]): self.size * dice.uniform(-2.0, 2.0)}
            case _:
                low, high = sorted(self.size * dice.uniform(-3.0, 3.0) for _ in range(2))
                return {"at_least": low, "at_most": high}

    def values(self, a: Any, b: Any) -> dict[str, Any]:
        """Return the values at both corners, one above the other."""
        sides = np.array([1.0 - self.part, 1.0 + self.part] if self.part else [1.0])[:, None]
        first, second = sides * self.k * a * b + self.c, a * a - self.m * b + self.d + 0.0 * sides
        return {"first": self.size * first, "second": self.size * second}

    def tuned(self, samples: int, starts: int) -> Tuned:
        free = {f"{name}.value": {"at_least": low, "at_most": high} for name, (low, high) in self.ends.items()}
        goals = {name: {"bias": f"{name}.output", "input": "source.output", **of} for name, of in self.goals.items()}
        tolerances = {"k.gain": self.part} if self.part else {}
        return tune(self.graph(), free=free, goals=goals, tolerances=tolerances, samples=samples, starts=starts)

    def graph(self) -> Graph:
        blocks: dict[str, Any] = {"source": Step(amplitude=self.size), "a": Constant(value=self.begin["a"])}
        blocks |= {"b": Constant(value=self.begin["b"]), "c": Constant(value=self.c), "d": Constant(value=self.d)}
        blocks |= {"ab": Product(), "aa": Product(), "k": Gain(gain=self.k), "m": Gain(gain=self.m)}
        blocks |= {"kab_c": Sum(), "aa_mb": Difference(), "aa_mb_d": Sum()}
        blocks |= {"sized_1": Gain(gain=self.size), "sized_2": Gain(gain=self.size), "first": Sum(), "second": Sum()}
        wires = """a ab.first, b ab.second, a aa.first, a aa.second, ab k.input, k kab_c.first, c kab_c.second,
            b m.input, aa aa_mb.first, m aa_mb.second, aa_mb aa_mb_d.first, d aa_mb_d.second, kab_c sized_1.input,
            aa_mb_d sized_2.input, sized_1 first.first, sized_2 second.first, source first.second,
            source second.second"""
        pairs = [wire.split() for wire in wires.split(",")]
        return Graph(
            name="levels",
            rate="1 kHz",
            blocks=blocks,
            wires=[f"{source}.output -> {target}" for source, target in pairs],
        )


def faults(number: int, samples: int = 16, starts: int = 2) -> list[str]:
    """Return what is wrong with what a tuning says."""
    levels = Levels(number)
    tuned, wrong = levels.tuned(samples, starts), []
    at = {name.partition(".")[0]: value for name, value in tuned.parameters.items()}
    there = levels.values(**at)
    for goal in tuned.goals:
        assert goal.after is not None
        low, high, wanted = np.min(there[goal.name]), np.max(there[goal.name]), levels.goals[goal.name]
        scale = max(abs(low), abs(high), 1e-3 * levels.size)
        if min(abs(goal.after - low), abs(goal.after - high)) > 1e-9 * scale:
            wrong.append(f"{goal.name} is {low:g} to {high:g}, not {goal.after:g}")
        least, most = wanted.get("at_least", -math.inf), wanted.get("at_most", math.inf)
        met = low - least >= -1e-8 * abs(low) and most - high >= -1e-8 * abs(high)
        if goal.goal.hard and goal.met != met:
            wrong.append(f"{goal.name} is {low:g} to {high:g}, and said to be met: {goal.met}")
    dice = np.random.default_rng(number)
    a, b = (dice.uniform(*ends, POINTS) for ends in levels.ends.values())
    corners = np.array(list(itertools.product(*levels.ends.values()))).T
    points = levels.values(np.append(a, corners[0]), np.append(b, corners[1]))
    sought = [name for name, wanted in levels.goals.items() if "minimise" in wanted or "maximise" in wanted]
    allowed, best, own = np.ones(POINTS + 4, dtype=bool), np.zeros(POINTS + 4), 0.0
    for name, wanted in levels.goals.items():
        rows, size = points[name], float(np.ptp(points[name]))
        allowed &= np.all(rows >= wanted.get("at_least", -math.inf) + NEAR * size, axis=0)
        allowed &= np.all(rows <= wanted.get("at_most", math.inf) - NEAR * size, axis=0)
        sign = -1.0 if wanted.get("maximise") else 1.0
        if [name] == sought:
            best, own = np.max(sign * rows, axis=0) / size, float(np.max(sign * there[name])) / size
    if allowed.any() and not tuned.met:
        wrong.append("random points meet all goals")
    if allowed.any() and tuned.met and float(np.min(best[allowed])) < own - NEAR:
        wrong.append(f"a random point is better by {own - float(np.min(best[allowed])):.2g} of the range")
    return wrong


@pytest.mark.parametrize("number", [1, 16])
def test_what_is_said_of_a_few_random_levels(number: int) -> None:
    assert faults(number, samples=1, starts=1) == []


@pytest.mark.exhaustive
@pytest.mark.parametrize("number", range(60))
def test_what_is_said_of_random_levels(number: int) -> None:
    assert faults(number) == []


if __name__ == "__main__":
    for number in range(*map(int, sys.argv[1:3])):
        if found := faults(number):
            print(number, Levels(number).goals, *found, sep="; ", flush=True)
