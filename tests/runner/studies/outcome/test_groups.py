"""Groups of Saltelli's design share their noise: intervals, ends of studies and comparisons count each group once."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy import stats

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.studies.build import Study
from proofmass.runner.comparison.studies import compare_studies
from proofmass.runner.studies.outcome.outcomes import Outcomes
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.outcome.running_means import RunningMeans
from proofmass.runner.studies.shown.points import differences
from proofmass.runner.studies.whole.study import run_study
from tests.by_hand.amounts import amounts

GRAPH = read_graph_text("""\
name = "a level"
rate = "1 kHz"
samples = 1
measures = { level = { signal = "source.output", statistic = "last" } }
blocks.source = { kind = "Constant", value = 0 }
""")
GROUP = 3  # of one parameter: A, B, and A with what B has
RUNS = 40 * GROUP


def study(seed: int = 1, **more: Any) -> Study:
    limits = {"level": {"at_most": 0.0}}
    spread = {"source.value": {"normal": 1}}
    return Study(GRAPH, runs=RUNS, seed=seed, design="saltelli", spread=spread, limits=limits, **more)


TAUGHT = run_study(study(), engine="python")


def of_noise(seed: int, runs: int = RUNS) -> StudyResult:
    """A result whose measure is noise alone, the same in the runs of a group."""
    noise = np.random.default_rng(seed).normal(size=RUNS // GROUP)
    values = np.repeat(noise, GROUP)[:runs, None]
    return replace(TAUGHT, study=study(seed), numbers=np.arange(runs), values={"level": values})


@pytest.mark.defect("S901", before="intervals of 95 % held 74 % of the means", after="they hold 95 %")
@pytest.mark.parametrize("seeds", amounts(60, 600))
def test_intervals_hold_what_they_say(seeds: int) -> None:
    held = np.zeros(2)
    for seed in range(seeds):
        result = of_noise(seed)
        (row,) = result.summary()
        low, high = row["intervals"]["mean"]
        least, most = result.yield_intervals()["level"]
        held += [low <= 0.0 <= high, least <= 0.5 <= most]
    assert min(held) >= 0.88 * seeds, "fewer of 60 are less likely than 1 in 50, of 600 than 1 in a million"


def test_the_interval_of_a_mean_is_students_of_the_groups() -> None:
    """The last group is not whole; a run without a value leaves its group to the others."""
    result = of_noise(5, RUNS - 1)
    values = result["level"].copy()
    values[1] = np.nan
    (row,) = replace(result, values={"level": values}).summary()
    groups = values[::GROUP, 0]
    half = stats.t.ppf(0.975, 39) * groups.std(ddof=1) / np.sqrt(40)
    assert result.sensors == 40
    assert row["intervals"]["mean"] == pytest.approx((groups.mean() - half, groups.mean() + half), rel=1e-12)
    assert row["intervals"]["std"] == (0.0, np.inf)
    assert row["intervals"]["p50"] == (-np.inf, np.inf)


@pytest.mark.defect("S901", before="a study ended with a mean that is known three times worse", after="at its group")
@pytest.mark.parametrize("together", [1, 7, RUNS])
def test_a_study_stops_once_its_groups_know_the_mean(together: int) -> None:
    values = of_noise(3)["level"][:, :, None]
    groups = values[::GROUP, 0, 0]
    halves = [stats.t.ppf(0.975, n - 1) * groups[:n].std(ddof=1) / np.sqrt(n) for n in range(30, 41)]
    last = 34
    stop = study(stop={"level": halves[last - 30] * 1.000001})
    means = RunningMeans(stop, TAUGHT.measures)
    for first in range(0, RUNS, together):
        numbers = np.arange(first, min(first + together, RUNS))
        means.add(Outcomes(numbers, values[numbers], {}))
    first_known = next(n for n, half in zip(range(30, 41), halves, strict=True) if half <= halves[last - 30] * 1.000001)
    assert (means.enough, means.end) == (True, first_known * GROUP)


@pytest.mark.defect("S901", before="a group of three counted as three sensors", after="as one")
def test_equal_studies_have_not_moved() -> None:
    """Noise alone: Student's test of 40 differences, as many as groups."""
    found = compare_studies(of_noise(1), replace(of_noise(2), study=study(1)))
    (mean,) = found.means
    one, other = (of_noise(seed)["level"][::GROUP, 0] for seed in (1, 2))
    probability = stats.ttest_rel(other, one).pvalue
    assert mean.runs == (40, 40)
    assert mean.probability >= probability
    assert not mean.moved


@pytest.mark.defect("S901", before="an interval of 120 differences", after="of 40, one for each group")
def test_differences_between_points_are_those_of_the_groups() -> None:
    before, after = of_noise(1), of_noise(2)
    (row,) = differences(before, after)
    apart = (after["level"] - before["level"])[::GROUP, 0]
    interval = stats.ttest_1samp(apart, 0.0).confidence_interval(0.95)
    assert row["sensors"] == 40
    assert row["interval"] == pytest.approx((interval.low, interval.high), rel=1e-12)


def scattered(seed: int, runs: int = RUNS - 2) -> StudyResult:
    """A result whose runs differ; the last group has one run alone, and the first one run without a value."""
    values = np.random.default_rng(seed).normal(size=(runs, 1))
    values[1] = np.nan
    return replace(TAUGHT, study=study(), numbers=np.arange(runs), values={"level": values})


def of_groups(values: Any) -> Any:
    """Means of groups by hand, without what is missing."""
    return np.array([np.nanmean(values[first : first + GROUP, 0]) for first in range(0, len(values), GROUP)])


@pytest.mark.defect("S985", before="777 runs had the mean 5.014, of which `diff` said 5.016", after="5.014 in both")
def test_a_comparison_counts_as_the_studies_do() -> None:
    before, after = scattered(1), scattered(2)
    compared = compare_studies(before, after)
    (mean,) = compared.means
    means = [of_groups(result["level"]).mean() for result in (before, after)]
    assert [result.summary()[0]["mean"] for result in (before, after)] == pytest.approx(means, rel=1e-14)
    assert (mean.before, mean.after) == pytest.approx(means, rel=1e-14)
    yields = [part for part in compared.yields if "has a value" not in part.limit]
    told = [(before.yields()[part.limit], after.yields()[part.limit]) for part in yields]
    assert [(part.before, part.after) for part in yields] == told


@pytest.mark.defect("S986", before="mean of the runs with the interval of the groups' mean", after="one mean of both")
def test_a_mean_lies_in_the_middle_of_its_interval() -> None:
    (row,) = scattered(1).summary()
    low, high = row["intervals"]["mean"]
    assert row["mean"] == pytest.approx(0.5 * (low + high), rel=1e-12)


@pytest.mark.defect("S985", before="the first run of each group was compared", after="all its runs")
def test_differences_between_points_take_all_runs_of_a_group() -> None:
    before, after = scattered(1), scattered(2)
    (row,) = differences(before, after)
    assert row["difference"] == pytest.approx(of_groups(after["level"] - before["level"]).mean(), rel=1e-12)


def test_yields_of_other_sensors_are_compared_by_groups() -> None:
    """Of 40 groups of three, 20 and 30 are good: Fisher's test of 40 sensors each, not of 120."""
    results = []
    for seed, good in ((1, 20), (2, 30)):
        values = np.repeat(np.where(np.arange(40) < good, -1.0, 1.0), GROUP)[:, None]
        results.append(replace(TAUGHT, study=study(seed), numbers=np.arange(RUNS), values={"level": values}))
    found = {part.limit: part for part in compare_studies(*results).yields}
    probability = stats.fisher_exact([[20, 20], [30, 10]]).pvalue
    assert (found["level"].before, found["level"].after) == (0.5, 0.75)
    assert found["level"].probability >= probability
    assert found["level"].probability <= 4 * probability
