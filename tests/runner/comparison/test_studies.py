"""Two studies compared: which means and yields moved, against tests computed by hand."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import stdtr

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.studies.build import Study
from proofmass.runner.comparison.studies import compare_studies
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.whole.study import run_study

GRAPH = read_graph_text("""\
name = "two gains"
rate = "1 kHz"
samples = 2
wires = ["source.output -> gain.input"]

[measures]
output = { signal = "gain.output", statistic = "last" }
input = { signal = "source.output", statistic = "last" }

[blocks]
source = { kind = "Constant", value = 1 }
gain = { kind = "Gain", gain = 1 }
""")
SPREAD = {"source.value": {"normal": 0.1}}
LIMITS = {"output": {"at_most": 1.1}}


def outcome(gain: float = 1.0, seed: int = 1, runs: int = 200, **more: object) -> StudyResult:
    graph = GRAPH.with_parameters({"gain.gain": gain})  # type: ignore[attr-defined]
    return run_study(Study(graph, seed=seed, runs=runs, spread=SPREAD, limits=LIMITS, **more), engine="python")  # type: ignore[arg-type]


BEFORE = outcome()


def test_the_same_sensors_are_compared_one_by_one() -> None:
    """A gain of 1.001 is a hundredth of the scatter, and each sensor shows it."""
    after = outcome(1.001)
    found = compare_studies(BEFORE, after)
    assert found.paired
    by_name = {change.measure: change for change in found.means}
    apart = after["output"][:, 0] - BEFORE["output"][:, 0]
    half = 1.9719565442493954 * apart.std(ddof=1) / math.sqrt(200)  # of Student's distribution with 199 degrees
    assert by_name["output"].interval == pytest.approx((apart.mean() - half, apart.mean() + half), rel=1e-9)
    assert by_name["output"].moved
    assert not by_name["input"].moved
    assert by_name["input"].probability == 1.0
    assert [difference.key for difference in found.differences] == ["blocks.gain.gain"]


def test_other_sensors_are_independent_samples() -> None:
    """Welch's test by its formula; the difference that one by one is plain is lost among other sensors."""
    after = outcome(1.001, seed=2, runs=150)
    found = compare_studies(BEFORE, after)
    assert not found.paired
    change = next(change for change in found.means if change.measure == "output")
    one, other = BEFORE["output"][:, 0], after["output"][:, 0]
    errors = [column.var(ddof=1) / len(column) for column in (one, other)]
    t = (other.mean() - one.mean()) / math.sqrt(sum(errors))
    freedom = sum(errors) ** 2 / (errors[0] ** 2 / 199 + errors[1] ** 2 / 149)
    probability = 2.0 * stdtr(freedom, -abs(t))
    all_of_them = sorted([probability, *(c.probability for c in found.means if c is not change)])
    assert change.probability >= probability
    assert not change.moved
    assert len(all_of_them) == 2
    assert {"study.runs", "study.seed"} <= {difference.key for difference in found.differences}


def test_a_yield_that_moves() -> None:
    after = outcome(1.1)
    found = compare_studies(BEFORE, after)
    good = [result["output"][:, 0] <= 1.1 for result in (BEFORE, after)]
    change = next(change for change in found.yields if change.limit == "output")
    assert (change.before, change.after) == (good[0].mean(), good[1].mean())
    lost = int((good[0] & ~good[1]).sum())
    assert int((good[1] & ~good[0]).sum()) == 0
    assert change.probability == pytest.approx(3 * 2.0 * 0.5**lost)  # Holm: three others are less likely by chance
    assert change.moved
    assert not found.same
    assert json.dumps(found.as_data())


def test_false_alarms_are_rare() -> None:
    """Of 200 comparisons of equal populations about ten are called moved; more than 22 would be, once in 3,000."""
    dice, other = np.random.default_rng(5), outcome(seed=2)
    alarms = 0
    for _ in range(200):
        drawn = [dice.normal(1.0, 0.1, (2, 200, 1)) for _ in range(2)]
        results = [
            replace(result, values=dict(zip(("output", "input"), values, strict=True)))
            for result, values in zip((BEFORE, other), drawn, strict=True)
        ]
        alarms += not compare_studies(*results).same
    assert alarms <= 22


def test_ages_that_both_have_are_compared() -> None:
    first = outcome(epochs={"ages": ["0 h", "1 h"]}, drift={"gain.gain": {"ramp": "0.1 1/h"}})
    second = outcome(epochs={"ages": ["1 h", "2 h"]}, drift={"gain.gain": {"ramp": "0.2 1/h"}})
    found = compare_studies(first, second)
    assert {change.age for change in found.means} == {3600.0}
    assert {difference.key for difference in found.differences} == {"study.epochs", "study.drift.gain.gain"}
