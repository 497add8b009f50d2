"""Worst cases of studies in which everything varies, against places and draws of a program of its own."""

import itertools
import random
from typing import Any

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.runner.design.worst.text import worst_text
from proofmass.runner.design.worst.worst import worst
from proofmass.runner.verification.verify import Measurements, verify
from tests.by_hand.amounts import chosen

YEARS = (0.0, 2.0, 5.0)


class System:
    """v; a = 2 v; b < 0; c, which may be correlated with b; d of a list; e, which drifts and walks; f < 0; g swept."""

    def __init__(self, seed: int) -> None:
        dice = random.Random(seed)
        self.weights = [dice.uniform(-1.0, 1.0) for _ in range(6)]
        self.b, self.f, self.v = -dice.uniform(1.0, 3.0), -dice.uniform(1.0, 3.0), dice.choice([-1.0, 1.5])
        self.choices, self.swept = [1.0, 2.5, 3.0], [-1.0, 0.5, 4.0]
        self.correlation = dice.choice([0.0, 0.0, 1.0, -1.0, 0.5, -0.3])
        blocks = {"a": '"= 2 * v"', "b": self.b, "c": 1.5, "d": 2.5, "e": 1.2, "f": self.f, "g": 0.5}
        lines = ['name = "sum"', 'rate = "1 kHz"', "samples = 1", f"values = {{ v = {self.v} }}", "[blocks]"]
        lines += [f'{name} = {{ kind = "Constant", value = {value} }}' for name, value in blocks.items()]
        lines += ["[measures]", *(f'of_{n} = {{ signal = "{n}.output", statistic = "last" }}' for n in blocks)]
        w = self.weights
        total = f"{w[0]}*of_a + {w[1]}*of_b*of_c + {w[2]}*of_d + {w[3]}*of_e + {w[4]}*of_f + {w[5]}*of_g*of_a"
        graph = read_graph_text("\n".join([*lines, f'total = "= {total}"']) + "\n")
        percent: dict[str, Any] = {"normal": "5 %", "relative": True}
        self.study = Study(
            graph,
            spread={
                "v": percent,
                "a.value": {"normal": "2 %", "relative": True, "truncated": 2.5},
                "b.value": percent,
                "c.value": {"lognormal": 0.1},
                "d.value": {"values": self.choices},
                "f.value": {"uniform": "10 %", "relative": True},
            },
            correlation={"b.value": {"c.value": self.correlation}} if self.correlation else {},
            sweep={"g.value": self.swept},
            epochs={"ages": [f"{age} year" for age in YEARS]},
            drift={"e.value": {"ramp": "1 %/year", "ramp_spread": "1 %/year", "random_walk": "0.1 1/sqrt(year)"}}
            if seed % 2
            else {"e.value": {"ramp": "3 %/year", "relative": True}},
        )
        self.walks = bool(seed % 2)

    def pair(self, b: Any, c: Any) -> Any:
        """The part of the sum that may be correlated."""
        return self.weights[1] * self.b * (1.0 + 0.05 * b) * 1.5 * np.exp(0.1 * c)

    def rest(self, v: Any, a: Any, d: Any, f: Any, g: Any, age: Any, pace: Any, walk: Any) -> Any:
        """The rest of the sum for standard deviates, choices and years."""
        value = 2.0 * self.v * (1.0 + 0.05 * v) * (1.0 + 0.02 * a)
        ramp = 0.01 * (1.0 + pace) * age + 0.1 * walk * np.sqrt(age)
        aged = 1.2 + ramp if self.walks else 1.2 * (1.0 + 0.03 * age)
        w = self.weights
        return w[0] * value + w[2] * d + w[3] * aged + w[4] * self.f * (1.0 + 0.1 * f) + w[5] * g * value

    def edge(self) -> Any:
        """Deviates of b and c at the edge of what exists."""
        if abs(self.correlation) == 1.0:
            along = np.linspace(-3.0, 3.0, 61)
            return along, along * self.correlation
        if not self.correlation:
            return np.array(list(itertools.product((-3.0, 0.0, 3.0), repeat=2))).T
        angles = np.linspace(0.0, 2.0 * np.pi, 1_000_001)
        first = np.sqrt(18.0) * np.cos(angles)
        second = self.correlation * first + np.sqrt(18.0 * (1.0 - self.correlation**2)) * np.sin(angles)
        within = np.minimum(1.0, 3.0 / np.maximum(np.abs(first), np.abs(second)))
        return first * within, second * within

    def ends(self) -> tuple[float, float]:
        """The least and largest sum at 3^n places, all choices, and the edge of the pair."""
        three = (-3.0, 0.0, 3.0)
        rows = (three, (-2.5, 0.0, 2.5), self.choices, (-1.0, 0.0, 1.0), self.swept, YEARS, three, three)
        rest, pair = self.rest(*np.array(list(itertools.product(*rows))).T), self.pair(*self.edge())
        return rest.min() + pair.min(), rest.max() + pair.max()

    def draws(self, count: int) -> Any:
        """The sum of sensors that are drawn as the study says, three standard deviations at most."""
        dice = np.random.default_rng(1)
        v, a, b, other, pace, walk = dice.normal(size=(6, count))
        c = self.correlation * b + np.sqrt(1.0 - self.correlation**2) * other
        within = (np.abs([v, b, c, other, pace, walk]) <= 3.0).all(axis=0) & (np.abs(a) <= 2.5)
        choices = (dice.choice(row, count) for row in (self.choices, self.swept, YEARS))
        d, g, age = choices
        rest = self.rest(v, a, d, dice.uniform(-1.0, 1.0, count), g, age, pace, walk)
        return (rest + self.pair(b, c))[within]


@pytest.mark.exhaustive("4")
@pytest.mark.exhaustive(but=1)
@pytest.mark.defect("S204", before="followers, correlations, drift and signs were left out", after="the ends of all")
@pytest.mark.parametrize("seed", chosen(range(4), range(4, 60)))
def test_nothing_that_varies_is_left_out(seed: int) -> None:
    system = System(seed)
    found = worst(system.study, {"total": {"measure": "total"}})
    lowest, highest = (case.worst for case in found.cases)
    assert lowest is not None
    assert highest is not None
    (least, largest), draws = system.ends(), system.draws(100_000)
    size = largest - least
    assert lowest == pytest.approx(least, abs=1e-5 * size), "nothing is worse, and it exists"
    assert highest == pytest.approx(largest, abs=1e-5 * size)
    assert lowest <= draws.min() + 1e-6 * size
    assert highest >= draws.max() - 1e-6 * size


NEGATIVE = """\
name = "one of two numbers is negative"
rate = "1 kHz"
samples = 1
wires = ["a.output -> s.first", "b.output -> s.second"]
measures.total = { signal = "s.output", statistic = "last" }
blocks.a = { kind = "Constant", value = -10 }
blocks.b = { kind = "Constant", value = 1 }
blocks.s.kind = "Sum"
[study.spread]
"a.value" = { normal = "10 %", relative = true }
"b.value" = { normal = "1 %", relative = true }
[requirements]
SYS-1 = { quantity = "total", at_most = -7, tolerances = "spread" }
"""


@pytest.mark.defect("S205", before="a negative parameter did not count: met, -8.97", after="missed, -5.97")
def test_a_negative_parameter_counts() -> None:
    study = read_study_text(NEGATIVE)
    (finding,) = verify(Measurements(study.graph, study))
    assert finding.value == pytest.approx(-10.0 * 0.7 + 1.03)


def test_tolerances_of_followers_lie_about_what_they_follow() -> None:
    text = NEGATIVE.partition("[study")[0].replace("-10", '"= 2 * v"') + "[values]\nv = -5\n"
    found = worst(read_graph_text(text), {"it": {"measure": "total"}}, tolerances={"v": "10 %", "a.value": "1 %"})
    assert [case.worst for case in found.cases] == pytest.approx([-10.0 * 1.1 * 1.01 + 1.0, -10.0 * 0.9 * 0.99 + 1.0])


def test_a_drift_without_a_mean_counts_at_the_last_age() -> None:
    text = (
        NEGATIVE.partition("[study")[0]
        + """[study.epochs]
ages = ["0 h", "1 year", "4 year"]
[study.drift]
"a.value" = { random_walk = "0.1 1/sqrt(year)" }
"b.value" = { ramp = "0 1/year", ramp_spread = "0.2 1/year" }
"""
    )
    found = worst(read_study_text(text), {"it": {"measure": "total"}}, corners=0, samples=1)
    widest = 3.0 * (0.1 * 2.0 + 0.2 * 4.0)
    assert [case.worst for case in found.cases] == pytest.approx([-9.0 - widest, -9.0 + widest])


@pytest.mark.defect("C200", before='"max() arg is an empty sequence"', after="nothing varies, and why")
def test_a_study_in_which_nothing_varies_is_refused_with_the_reason() -> None:
    text = NEGATIVE.replace("-10", "0").partition('"b.value"')[0]
    with pytest.raises(ModelError, match="nothing varies") as told:
        worst(read_study_text(text), {"it": {"measure": "total"}})
    assert "a.value: its range moves nothing" in str(told.value)
    whole = read_study_text(NEGATIVE.replace("-10", "0").partition("[req")[0])
    found = worst(whole, {"it": {"measure": "total"}})
    assert [wanted.name for wanted in found.ranges] == ["b.value"]
    assert found.left_out == {"a.value": "its range moves nothing"}
    assert "a.value does not count: its range moves nothing" in worst_text(found)
