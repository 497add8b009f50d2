"""Two studies compared: which means and yields moved, against tests computed by hand."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from scipy.special import stdtr

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.studies.build import Study
from proofmass.runner.comparison.studies import compare_studies
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.whole.study import run_study
from tests.by_hand.amounts import amounts

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
    assert change.difference == pytest.approx(other.mean() - one.mean())
    of_scipy = stats.ttest_ind(other, one, equal_var=False).confidence_interval(0.95)
    assert change.interval == pytest.approx((of_scipy.low, of_scipy.high))
    assert len(all_of_them) == 2
    assert {"study.runs", "study.seed"} <= {difference.key for difference in found.differences}


@pytest.mark.friendly(36, "a yield that moves between studies")
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


@pytest.mark.exhaustive
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


@pytest.mark.exhaustive
def test_ages_that_both_have_are_compared() -> None:
    first = outcome(epochs={"ages": ["0 h", "1 h"]}, drift={"gain.gain": {"ramp": "0.1 1/h"}})
    second = outcome(epochs={"ages": ["1 h", "2 h"]}, drift={"gain.gain": {"ramp": "0.2 1/h"}})
    found = compare_studies(first, second)
    assert {change.age for change in found.means} == {3600.0}
    assert {difference.key for difference in found.differences} == {"study.epochs", "study.drift.gain.gain"}


MANY = [float(point) for point in range(20)]


def at_points(seed: int, runs: int = 50, points: list[float] = MANY, offset: float = 0.0) -> StudyResult:
    """Sensors with a normal offset at every point; `both` moves with the point."""
    text = """\
name = "offsets"
rate = "1 kHz"
samples = 1
wires = ["offset.output -> both.first", "point.output -> both.second"]
[measures]
offset = { signal = "offset.output", statistic = "last" }
both = { signal = "both.output", statistic = "last" }
[blocks]
offset = { kind = "Constant", value = 0 }
point = { kind = "Constant", value = 0 }
both = { kind = "Sum" }
"""
    graph = read_graph_text(text).with_parameters({"offset.value": offset})  # type: ignore[attr-defined]
    study = Study(
        graph,
        runs=runs,
        seed=seed,
        spread={"offset.value": {"normal": 1}},
        sweep={"point.value": points},
        limits={"offset": {"at_least": -0.5, "at_most": 0.5}},
    )
    result = run_study(study.changed(runs=1, seed=seed), engine="python")  # its form; the numbers are our own
    drawn = offset + np.random.default_rng(seed).normal(size=runs)
    columns = {"offset": np.repeat(drawn, len(points)), "both": np.add.outer(drawn, points).ravel()}
    values = {name: column[:, None] for name, column in columns.items()}
    return replace(result, study=study, numbers=np.arange(runs * len(points)), values=values)


@pytest.mark.defect("S207", before="with 20 points intervals of 95 % held 28 %", after="they hold 95 %")
@pytest.mark.parametrize("seeds", amounts(40, 300))
def test_points_of_a_sweep_are_no_more_sensors(seeds: int) -> None:
    truth = {"offset": 0.0, "both": float(np.mean(MANY))}
    good = 0.38292492254802624  # of a normal deviate within half a standard deviation
    held = dict.fromkeys([*truth, "yield"], 0)
    for seed in range(seeds):
        result = at_points(seed)
        for row in result.summary():
            low, high = row["intervals"]["mean"]
            held[row["measure"]] += low <= truth[row["measure"]] <= high
        low, high = result.yield_intervals()["offset"]
        held["yield"] += low <= good <= high
    assert all(times >= 0.93 * seeds for times in held.values()), held


@pytest.mark.exhaustive
@pytest.mark.defect("S208", before="equal studies of 20 points had moved in 80 % of all cases", after="5 % at most")
def test_equal_studies_of_many_points_have_not_moved() -> None:
    moved = sum(not compare_studies(at_points(seed, points=MANY[:5]), at_points(1000 + seed, points=MANY[:5])).same
                for seed in range(100))  # fmt: skip
    assert moved <= 12, "more is less likely than 1 in 1,000"


@pytest.mark.defect("S209", before="changes that oppose each other at two points were averaged", after="both are told")
def test_points_are_compared_one_by_one() -> None:
    before = at_points(1, points=[-1.0, 1.0])
    opposed = before["both"] + 0.01 * np.tile([1.0, -1.0], 50)[:, None]
    after = replace(before, values={**before.values, "both": opposed})
    found = compare_studies(before, after)
    changes = {change.point: change for change in found.means if change.measure == "both"}
    assert [c.difference for c in changes.values()] == pytest.approx([0.01, -0.01])
    assert all(change.moved and change.pairing > 100.0 for change in changes.values())
    assert list(changes) == ["point.value = -1", "point.value = 1"]


def test_points_that_only_one_study_has_are_left_out() -> None:
    found = compare_studies(at_points(1, points=[0.0, 1.0]), at_points(1, points=[1.0, 2.0, 3.0]))
    assert {change.point for change in found.means} == {"point.value = 1"}
    alone = compare_studies(at_points(1, points=[5.0]), at_points(1, points=[1.0, 2.0]))
    assert {change.point for change in alone.means} == {"point.value = 1", "point.value = 2"}


@pytest.mark.exhaustive
def test_yields_are_compared_at_each_age_too() -> None:
    aged = {"epochs": {"ages": ["0 h", "1 h"]}, "drift": {"gain.gain": {"ramp": "0.1 1/h"}}}
    found = compare_studies(outcome(**aged), outcome(1.05, **aged))  # type: ignore[arg-type]
    rows = {(change.limit, change.age): change for change in found.yields}
    assert set(rows) == {(limit, age) for limit in ("output", "all limits") for age in (None, 0.0, 3600.0)}
    assert rows["output", 3600.0].before == np.mean(outcome(**aged)["output"][:, 1] <= 1.1)  # type: ignore[arg-type]


@pytest.mark.defect("S897", before="a measure that no sensor has any more had not moved", after="fewer have a value")
@pytest.mark.parametrize(("lost", "moved"), [(200, True), (12, True), (2, False)])
def test_sensors_that_lose_the_value_of_a_measure(lost: int, moved: bool) -> None:
    """Of so many that change to one side half of each other is likely: 2 / 2^lost, among four comparisons at most."""
    values = {**BEFORE.values, "output": np.where(np.arange(200) < lost, np.nan, BEFORE["output"][:, 0])[:, None]}
    bare = replace(BEFORE, study=BEFORE.study.with_limits({}))
    found = compare_studies(bare, replace(bare, values=values))
    (part,) = found.yields
    assert (part.limit, part.before, part.after) == ("output has a value", 1.0, 1.0 - lost / 200)
    assert part.moved == moved
    assert part.probability <= 4 * 2.0 ** (1 - lost)
    assert found.same == (not moved)
    assert compare_studies(replace(bare, values=values), replace(bare, values=values)).same


@pytest.mark.defect("S898", before="means of 1 V and 1 mV had not moved", after="another unit is another measure")
def test_measures_in_other_units_have_no_common_mean() -> None:
    measures = tuple(replace(m, unit="mV") if m.name == "output" else m for m in BEFORE.measures)
    found = compare_studies(BEFORE, replace(BEFORE, measures=measures))
    assert [change.measure for change in found.means] == ["input"]
    assert [(d.key, d.before, d.after) for d in found.differences] == [("unit of output", "1", "mV")]
    assert not found.same


@pytest.mark.defect(
    "S909", before="studies of one sensor each compared nothing, and nothing had moved", after="it is named"
)
@pytest.mark.parametrize(("gain", "seed", "same"), [(1.0, 1, True), (2.0, 1, False), (1.0, 2, False)])
def test_one_sensor_alone_has_moved_if_it_differs(gain: float, seed: int, same: bool) -> None:
    """How far sensors scatter is not known of one: no difference of it can be called small."""
    compared = compare_studies(outcome(runs=1), outcome(gain, seed=seed, runs=1))
    assert compared.same is same
    assert bool(compared.alone) is not same
    assert compared.as_data()["alone"] == [*compared.alone]
    assert not compared.means


def test_one_sensor_beside_many_is_named() -> None:
    compared = compare_studies(outcome(runs=1), outcome(seed=2, runs=20))
    assert compared.alone == tuple(outcome(runs=1).values)
    assert not compared.same
