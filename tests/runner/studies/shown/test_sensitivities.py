"""Sobol indices and regressions against closed forms: a linear model, Ishigami's function, and ranks of SciPy."""

import dataclasses
import itertools
import math
from collections.abc import Callable, Mapping

import numpy as np
import pytest
from scipy import stats

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.studies.build import Study
from proofmass.runner.studies.draws.factors import Drawn
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.sensitivities import _indices, _ranks, regression, sobol_indices
from proofmass.runner.studies.whole.study import run_study

GRAPH = read_graph_text("""
name = "three numbers"
rate = "1 kHz"
samples = 2
wires = ["a.output -> twice.input", "twice.output -> ab.first", "b.output -> ab.second", "ab.output -> abc.first",
    "c.output -> abc.second"]
measures.sum = { signal = "abc.output", statistic = "last" }
blocks.a = { kind = "Constant" }
blocks.b = { kind = "Constant" }
blocks.c = { kind = "Constant" }
blocks.twice = { kind = "Gain", gain = 2.0 }
blocks.ab = { kind = "Sum" }
blocks.abc = { kind = "Sum" }
""")
NAMES = ("a.value", "b.value", "c.value")


def study(design: str, runs: int, width: dict[str, float]) -> Study:
    return Study(GRAPH, runs=runs, seed=4, design=design, spread=dict.fromkeys(NAMES, width))


def result_of(made: Study, function: Callable[..., float]) -> StudyResult:
    """A result as if the measure were this function of the parameters."""
    ran = run_study(made.changed(runs=1, seed=made.seed), engine="python")
    values = np.array([[function(*(made.drawn(k)[0][name] for name in NAMES))] for k in range(made.runs)])
    return dataclasses.replace(
        ran, study=made, numbers=np.arange(made.runs), values={"sum": values}, planned_runs=made.runs
    )


def linear(a: float, b: float, c: float) -> float:
    return 2.0 * a + b + c


def ishigami(a: float, b: float, c: float) -> float:
    return math.sin(a) + 7.0 * math.sin(b) ** 2 + 0.1 * c**4 * math.sin(a)


@pytest.mark.exhaustive
def test_a_study_of_a_linear_graph() -> None:
    """Variances 4 : 1 : 1, without interactions; computed by the graph itself."""
    result = run_study(study("saltelli", 5 * 256, {"normal": 0.1}), engine="python")
    indices = sobol_indices(result, "sum")
    assert [index.parameter for index in indices] == list(NAMES)
    for index, expected in zip(indices, (4 / 6, 1 / 6, 1 / 6), strict=True):
        assert index.first == pytest.approx(expected, abs=0.02)
        assert index.total == pytest.approx(expected, abs=0.02)
        assert index.first_interval[0] - 0.02 <= expected <= index.first_interval[1] + 0.02
        assert index.total_interval[0] <= index.total <= index.total_interval[1]


@pytest.mark.exhaustive
def test_the_function_of_ishigami() -> None:
    """Ishigami and Homma (1990) with a = 7, b = 0.1: variances of the parts in closed form."""
    a, b = 7.0, 0.1
    first = [0.5 * (1.0 + b * math.pi**4 / 5.0) ** 2, a**2 / 8.0, 0.0]
    both = b**2 * math.pi**8 * 8.0 / 225.0
    variance = sum(first) + both
    expected = {
        "a.value": (first[0] / variance, (first[0] + both) / variance),
        "b.value": (first[1] / variance, first[1] / variance),
        "c.value": (0.0, both / variance),
    }
    indices = sobol_indices(result_of(study("saltelli", 5 * 2048, {"uniform": math.pi}), ishigami), "sum")
    for index in indices:
        assert (index.first, index.total) == pytest.approx(expected[index.parameter], abs=0.015)
    assert sum(index.total for index in indices) > 1.1


def test_groups_with_a_failed_run_are_left_out_and_other_designs_have_no_indices() -> None:
    whole = result_of(study("saltelli", 5 * 128 + 3, {"normal": 0.1}), linear)
    values = whole["sum"].copy()
    values[7] = np.nan
    left = dataclasses.replace(whole, values={"sum": values})
    less = dataclasses.replace(
        whole,
        numbers=np.delete(whole.numbers, range(5, 10)),
        values={"sum": np.delete(whole["sum"], range(5, 10), axis=0)},
    )
    assert sobol_indices(left, "sum") == sobol_indices(less, "sum") != sobol_indices(whole, "sum")
    assert sobol_indices(result_of(study("sobol", 64, {"normal": 0.1}), linear), "sum") == []
    assert sobol_indices(result_of(study("saltelli", 9, {"normal": 0.1}), linear), "sum") == []
    assert sobol_indices(result_of(study("saltelli", 50, {"normal": 0.1}), lambda a, b, c: 1.0), "sum") == []


@pytest.mark.exhaustive
def test_regression_of_a_linear_model() -> None:
    result = result_of(study("latin_hypercube", 300, {"normal": 0.1}), linear)
    found = regression(Drawn(result.study, result.numbers).factors(0).columns, result["sum"][:, 0])
    assert found is not None
    assert found.runs == 300
    assert found.explained == pytest.approx(1.0, abs=1e-12)
    assert found.influences[0].parameter == "a.value"
    for influence in found.influences:
        assert influence.slope == pytest.approx(2.0 if influence.parameter == "a.value" else 1.0, rel=1e-9)
        assert influence.effect == pytest.approx(0.1 * influence.slope, rel=0.02)
        assert influence.standardised == pytest.approx(influence.slope / math.sqrt(6.0), rel=0.1)


def test_ranks_see_what_straight_lines_do_not() -> None:
    dice = np.random.default_rng(6)
    x = {"one": dice.normal(size=500)}
    y = np.exp(4.0 * x["one"]) + 0.1 * dice.normal(size=500)
    found = regression(x, y)
    assert found is not None
    assert found.influences[0].rank == pytest.approx(stats.spearmanr(x["one"], y).statistic, rel=1e-12)
    assert found.influences[0].standardised == pytest.approx(np.corrcoef(x["one"], y)[0, 1], rel=1e-12)
    assert found.explained < 0.5 < 0.9 < found.explained_of_ranks


def test_against_least_squares_with_a_constant() -> None:
    dice = np.random.default_rng(7)
    table: Mapping[str, np.ndarray[tuple[int], np.dtype[np.float64]]] = {
        name: dice.normal(1e3, 5.0, 40) for name in "abc"
    } | {"still": np.ones(40)}
    y = np.sin(table["a"]) + 0.3 * table["b"]
    found = regression(table, np.append(y[:-1], np.nan))
    assert found is not None
    assert found.runs == 39
    design = np.column_stack([np.ones(39), *(table[name][:-1] for name in "abc")])
    expected = dict(zip("abc", np.linalg.lstsq(design, y[:-1], rcond=None)[0][1:], strict=True))
    assert {i.parameter: i.slope for i in found.influences} == pytest.approx(expected, rel=1e-8)


def test_nothing_to_explain() -> None:
    column = np.arange(10.0)
    assert regression({}, column) is None
    assert regression({"a": column}, np.ones(10)) is None
    assert regression({"a": np.ones(10)}, column) is None
    assert regression({"a": column[:3]}, column[:3]) is None


@pytest.mark.exhaustive("400")
@pytest.mark.parametrize(("runs", "times"), [(200, 150), (8, 400), (200, 400)])
def test_intervals_of_an_influence(runs: int, times: int) -> None:
    """Of one parameter, those of SciPy's straight line; of three, they cover what is true 95 times of 100."""
    dice = np.random.default_rng(8)
    x = dice.normal(size=runs)
    y = 3.0 * x + dice.normal(size=runs)
    found = regression({"x": x}, y)
    assert found is not None
    line = stats.linregress(x, y)
    half = stats.t.ppf(0.975, runs - 2) * line.stderr * x.std(ddof=1)
    assert found.influences[0].effect_half == pytest.approx(half, rel=1e-9)
    covered = 0
    for _ in range(times):
        columns = {name: dice.normal(size=runs) for name in "abc"}
        made = regression(columns, 2.0 * columns["a"] + columns["b"] + dice.normal(size=runs))
        assert made is not None
        for influence in made.influences:
            true = {"a": 2.0, "b": 1.0, "c": 0.0}[influence.parameter] * columns[influence.parameter].std(ddof=1)
            covered += abs(influence.effect - true) <= influence.effect_half
    assert covered / (3 * times) == pytest.approx(0.95, abs=0.03)  # standard error 0.006 to 0.01


@pytest.mark.parametrize("runs", [5, 12, 400])
def test_factors_are_one_beyond_three_standard_errors_of_their_correlation(runs: int) -> None:
    """Fisher: atanh r has the standard error 1 / sqrt(n - 3)."""
    border = math.tanh(math.atanh(0.9) + 3.0 / math.sqrt(runs - 3.0))
    dice = np.random.default_rng(9)
    columns = dice.normal(size=(runs, 3))
    first, other, noise = np.linalg.qr(columns - columns.mean(axis=0))[0].T
    for r, together in ((border - 1e-6, False), (border + 1e-6 * (1.0 - border), True)):
        found = regression({"a": first, "b": r * first + math.sqrt(1.0 - r * r) * other}, first + noise)
        assert found is not None
        assert len(found.influences) == (1 if together else 2), r


def test_indices_of_all_combinations_are_exact() -> None:
    """Of 2 x + y the parts are 4 / 5 and 1 / 5; of x y nothing is due to one alone, and all to both."""
    signs = np.array(list(itertools.product((-1.0, 1.0), repeat=4)))
    a, b = signs[:, :2], signs[:, 2:]
    mixed = [np.column_stack([b[:, 0], a[:, 1]]), np.column_stack([a[:, 0], b[:, 1]])]

    def groups(function: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> np.ndarray:  # type: ignore[type-arg]
        return np.column_stack([function(*x.T) for x in (a, b, *mixed)])

    assert _indices(groups(lambda x, y: 2.0 * x + y + 7.0)) == pytest.approx(np.array([[0.8, 0.2], [0.8, 0.2]]))
    assert _indices(groups(lambda x, y: x * y)) == pytest.approx(np.array([[0.0, 0.0], [1.0, 1.0]]))


def test_equal_values_share_their_mean_rank() -> None:
    column = np.array([3.0, 1.0, 3.0, 2.0, 3.0, 0.0])
    assert _ranks(column[:, None])[:, 0].tolist() == stats.rankdata(column).tolist()
