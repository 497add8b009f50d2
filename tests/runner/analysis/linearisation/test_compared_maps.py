"""Changes between maps with wires that hold their values: those of all values, taken of one each."""

from dataclasses import replace

import numpy as np
import pytest

from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.map_changes import change_between, effect
from proofmass.runner.analysis.linearisation.orbit_run import ComparedMaps
from proofmass.runner.analysis.linearisation.period_map import PeriodMap

N, INPUTS = 3, 4


def held(seed: int, runs: tuple[int, ...]) -> PeriodMap:
    """A stable map with a wire whose values are held for so many ticks each, and another that changes in each tick."""
    draw = np.random.default_rng(seed)
    states = draw.normal(size=(N, N + INPUTS + 1)) * 0.2
    values = [
        np.repeat(draw.normal(size=(len(runs), N + INPUTS + 1)), runs, axis=0),
        draw.normal(size=(2, N + INPUTS + 1)),
    ]
    outputs = (*(("slow", "output", i) for i in range(sum(runs))), ("fast", "output", 0), ("fast", "output", 1))
    return PeriodMap(
        tuple((f"block {i}", "x", -1) for i in range(N)),
        tuple(("white", "normal", i) for i in range(INPUTS)),
        outputs,
        np.vstack([states, *values]),
        {},
        1.0,
    )


@pytest.mark.parametrize("runs", [(1, 6), (3, 3), (1, 1, 1), (5,)])
def test_changes_are_those_of_all_values(runs: tuple[int, ...]) -> None:
    first = held(1, runs)
    after = replace(first, matrix=0.9 * first.matrix + 0.1 * held(2, runs).matrix)
    compared = ComparedMaps(Ends((), (("slow", "output"), ("fast", "output"))))
    z = np.exp(1j * np.geomspace(1e-3, 3.0, 7))
    assert compared.change(first, after) == pytest.approx(change_between(first, after), rel=1e-12)
    assert compared.effect(first, after, z) == pytest.approx(effect(first, after, z), rel=1e-12)
    assert change_between(first, after) > 0.01


def test_maps_of_the_same_numbers_are_one() -> None:
    """Those of noise are compared once, wherever the operating point is; other numbers are another map."""
    noise = {"white": ()}
    compared = ComparedMaps(Ends((), (("slow", "output"),), noise=noise))
    first, again, other = held(1, (3, 3)), held(1, (3, 3)), held(2, (3, 3))
    again.matrix[:, -1] += 1.0  # the steps of the orbit
    assert compared.shown(first) is compared.shown(again)
    assert compared.shown(first) is not compared.shown(other)
    assert (compared.change(first, again), compared.change(other, other)) == (0.0, 0.0)
