"""Parts of the report of a study, whole, from values that were written by hand."""

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from proofmass.graphs.studies.ages import YEAR
from proofmass.graphs.studies.study_tables import Limit
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown import report
from proofmass.runner.studies.shown.influences import StudyInfluences
from proofmass.runner.studies.shown.proved import ProvedBound
from proofmass.runner.studies.shown.sensitivities import Index, Regression
from tests.by_hand.study_results import AGED, LIMITED, SWEPT, study_result
from tests.runner.studies.shown.test_plot import influence


def rows_of(text: str) -> list[list[str]]:
    """The cells of a table, without tags."""
    rows = [row.partition("</tr>")[0] for row in text.split("<tr>")[1:]]
    return [[bare(cell) for cell in row.replace("</th>", "</td>").split("</td>")[:-1]] for row in rows]


def numbers_of(text: str) -> list[int]:
    """The columns of a table that are numbers, aligned right."""
    heads = text.partition("<tr>")[2].partition("</tr>")[0].split("<th")[1:]
    return [place for place, head in enumerate(heads) if head.startswith(' class="number"')]


def bare(text: str) -> str:
    """A text without tags."""
    return "".join(part.partition(">")[2] for part in ("x>" + text).split("<"))


def opened(points: int, intervals: int, epochs: tuple[float, ...], runs: int, planned: int) -> str:
    study = SimpleNamespace(
        graph=SimpleNamespace(description="One.\n\nTwo & three."),
        epochs=epochs,
        points=points,
        recalibration=SimpleNamespace(every=(1.0,) * intervals),
        seed=7,
    )
    result: Any = SimpleNamespace(study=study, numbers=range(runs), planned_runs=planned, interrupted=runs < planned)
    return report._opening(result)


@pytest.mark.parametrize(
    ("points", "intervals", "epochs", "said"),
    [
        (1, 1, (0.0,), ""),
        (2, 1, (0.0, 3.0 * YEAR), " at 2 ages up to 3 years, 2 points of the sweep"),
        (2, 2, (0.0,), ", 2 intervals between calibrations"),
        (6, 3, (0.0,), ", 2 points of the sweep, 3 intervals between calibrations"),
    ],
)
def test_the_opening_counts_what_was_tried(points: int, intervals: int, epochs: tuple[float, ...], said: str) -> None:
    expected = f'<p>One.</p>\n<p>Two &amp; three.</p>\n<p><span class="soft">1,200 runs{said}, seed 7</span></p>\n'
    assert opened(points, intervals, epochs, 1200, 1200) == expected
    warning = '<p class="warning">1,200 of 2,000 runs are done.</p>'
    assert opened(points, intervals, epochs, 1200, 2000) == expected + warning


def test_yields_stand_beside_their_limits() -> None:
    """2 of 3 and 1 of 3: exact ends 9.43 to 99.16 and 0.84 to 90.57 %; a change is counted from the first year on."""
    limits = (
        'limits = { bias = { at_least = -2, at_most = 3, change = "100 ppm", from = "1 year" }, noise.at_most = 8 }'
    )
    bias, noise = [[9, 1, 1], [9, 1, 1], [0, 1, 2]], [[5, 6, 7], [5, 6, 9], [8, 8, 8.5]]
    result = study_result(AGED + limits, {"bias": bias, "noise": noise}, {"bias": "V"})
    assert numbers_of(report._yield(result)) == [2, 3]
    assert rows_of(report._yield(result)) == [
        ["measure", "limit", "good", "95 % confidence"],
        ["bias", "≥ −2 V, ≤ 3 V, change ≤ 100 ppm, from 1 year", "66.67 %", "9.43 to 99.16 %"],
        ["noise", "≤ 8", "33.33 %", "0.84 to 90.57 %"],
        ["all limits", "", "33.33 %", "0.84 to 90.57 %"],
    ]


def test_the_table_of_measures_has_half_of_each_interval_and_what_few_runs_bound() -> None:
    """Of 3 runs nothing bounds the deviation or a percentile; 7 ages of 13 are told, the last among them."""
    ages = f"epochs = {{ ages = {[0, *range(3, 27, 2)]} }}\n"
    values = [[1.0] * 13, [2.0] * 13, [3.0] * 12 + [np.nan]]
    result = study_result(ages, {"bias": values}, {"bias": "V"})
    text = report._measures(result)
    about = "In brackets half of the 95 % confidence interval, in units of the last digits; below percentiles that"
    assert bare(text).startswith(f"{about} few runs tell of, their bound. Runs that failed are left out.measureunit")
    assert numbers_of(text) == [2, 3, 4, 5, 6, 7, 8]
    head, first, *others = rows_of(text)
    assert head == ["measure", "unit", "age", "runs", "mean", "std", "p1", "p50", "p99"]
    assert first[:6] == ["bias", "V", "0 h", "3", "2.0(25)", "1≥ 0"]
    assert [row[2] for row in others] == ["5 s", "9 s", "13 s", "17 s", "21 s", "25 s"]
    assert others[-1][3:6] == ["2", "1.5(64)", "0.707107≥ 0"]


def test_an_interval_without_an_end_is_told_as_a_bound() -> None:
    row = {"mean": 2.0, "std": 1.0, "runs": 3, "intervals": {"mean": (1.75, 2.25), "std": (0.5, math.inf)}}
    assert report._with_interval(row, "mean") == "2.00(25)"
    assert report._with_interval(row, "std") == "1<br><small>≥ 0.5</small>"
    assert [report._with_interval(row, key) for key in ("p1", "runs")] == ["", ""]
    assert report._with_interval({"mean": 2.0}, "mean") == ""


def test_curves_are_drawn_over_parameters_of_three_values_of_measures_that_are_known(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(report, "sweep_picture", lambda result, measure, name: f"{measure.name} over {name}")
    swept = 'sweep = { "filter.corner_frequency" = [1, 2], "source.value" = [1, 2, 1], "adc.reference" = [5, 6, 7] }\n'
    values = {"bias": [[float(k)] for k in range(18)], "noise": [[np.nan]] * 18}
    assert report._curves(study_result(swept, values)) == '<div class="wide">bias over adc.reference</div>'


SINCE_FIRST = " Changes are those since the first age."


@pytest.mark.parametrize(
    ("drift", "carried", "epoch", "since", "said"),
    [
        ({}, {}, 1, (0, 0), ""),
        ({"a": 1}, {}, 0, (0, 0), ""),
        ({"a": 1}, {}, 1, (0, 0), SINCE_FIRST),
        ({"a": 1}, {}, 1, (0, 1), SINCE_FIRST),
        ({"a": 1}, {"a": "b"}, 2, (1, 1), " Changes are those since the last calibration, at 1 year."),
        ({"a": 1}, {"a": "b"}, 2, (1, 0), " Changes are those since the last calibration."),
        ({"a": 1}, {"a": "b"}, 2, (0, 1), " Changes are those since the last calibration."),
    ],
)
def test_changes_are_said_to_count_from_an_age_that_all_runs_share(
    drift: dict[str, Any], carried: dict[str, str], epoch: int, since: tuple[int, int], said: str
) -> None:
    recalibration = SimpleNamespace(carried=carried)
    study: Any = SimpleNamespace(drift=drift, recalibration=recalibration, epochs=(0.0, YEAR, 2.0 * YEAR))
    influences: Any = SimpleNamespace(epoch=epoch, since=np.array(since))
    assert report._since_text(study, influences) == said


def test_an_effect_has_its_interval_below() -> None:
    assert report._effect(influence(1.5)) == "1.50(12)<br><small>1.375 to 1.625</small>"


def test_the_three_strongest_factors_are_told_at_each_age() -> None:
    study: Any = SimpleNamespace(epochs=(0.0, YEAR))
    strongest = tuple(
        influence(1.0, name, share=share) for name, share in zip("abcd", (0.4, 0.3, 0.2, 0.1), strict=True)
    )
    tables: Any = [SimpleNamespace(epoch=epoch, regression=Regression(strongest, 0.9, 0.8, 9)) for epoch in (0, 1)]
    text = report._leading(study, tables)
    told = "a 40.0 %, b 30.0 %, c 20.0 %"
    assert rows_of(text) == [
        ["age", "explained", "strongest factors, share of the variance"],
        ["0 h", "90.0 %", told],
        ["1 year", "90.0 %", told],
    ]
    assert numbers_of(text) == [0, 1]


def test_indices_are_told_at_the_last_age_with_their_intervals(monkeypatch: pytest.MonkeyPatch) -> None:
    index = Index("adc.reference", 0.25, (0.125, 0.375), 0.5, (0.4375, 0.5625))
    asked = []

    def indices(result: StudyResult, measure: str, epoch: int, point: int) -> list[Index]:
        asked.append((measure, epoch, point))
        return [index] if measure == "bias" else []

    monkeypatch.setattr(report, "sobol_indices", indices)
    result = study_result(AGED, {"bias": [[1, 2, 3]], "noise": [[1, 2, 3]]})
    text = report._indices(result)
    assert text.startswith("<p>Sensors of a group share the noise; what these do is in no index.</p>\n<div")
    assert rows_of(text) == [
        ["measure", "parameter", "first order", "total"],
        ["bias", "adc.reference", "0.2500.125 to 0.375", "0.5000.438 to 0.562"],
    ]
    assert numbers_of(text) == [2, 3]
    assert asked[:2] == [("bias", 2, 0), ("noise", 2, 0)]
    drifting = 'drift = { "adc.reference" = { ramp = "1 V/year" } }\n'
    text = report._indices(study_result(AGED + drifting, {"bias": [[1, 2, 3]]}))
    assert text.startswith("<p>Sensors of a group share the noise, and the drift of adc.reference; what")
    assert report._indices(study_result(AGED, {"noise": [[1, 2, 3]]})) == ""
    nobody = study_result(AGED, {"bias": [[1, 2, 3]]})
    nobody = replace(nobody, numbers=nobody.numbers[:0], values={"bias": nobody["bias"][:0]})
    assert report._indices(nobody) == ""


def saved(result: StudyResult, path: Path, **given: Any) -> dict[str, str]:
    """The sections of a report."""
    text = report.save_study_report(result, path, **given).read_text()
    parts = (part.partition("</h2>\n") for part in text.split("<section>\n<h2>")[1:])
    return {head: body.partition("\n</section>")[0] for head, _, body in parts}


ALWAYS = ["Measures", "Distributions", "Runs to look at", "Study", "To repeat it"]


def test_the_sections_of_a_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is not there has no section; influences that are known already are those of units as they are."""
    monkeypatch.setattr(report, "picture", lambda figure, title: title)
    known: list[Any] = []
    monkeypatch.setattr(report, "_influences", lambda result, influences: known.append(influences) or "")
    result = study_result("", {"bias": [[1.0], [2.0], [3.0]]})
    sections = saved(result, tmp_path / "a.html")
    assert list(sections) == ALWAYS
    assert sections["Distributions"] == '<div class="wide">distribution of bias</div>'
    assert "<footer>proofmass 0.1.0, 2026-01-02" in (tmp_path / "a.html").read_text()
    given = StudyInfluences(result)
    bound = ProvedBound("bias", "a bias", 0.5, "1 %", ())
    assert list(saved(result, tmp_path / "b.html", influences=given, proved=[bound])) == [
        "Measures",
        "Proved",
        *ALWAYS[1:],
    ]
    assert known[0] is not given
    assert known[1] is given
    small = study_result(LIMITED, {"bias": [[1e-6], [2e-6]], "noise": [[1], [1]]}, {"bias": "V"})
    sections = saved(small, tmp_path / "c.html", influences=given)
    assert list(sections) == ["Yield", *ALWAYS]
    assert ">µV<" in sections["Measures"]
    assert known[2] is not given
    assert facts_of(small)[4][1] in sections["Study"], "of the values as they were kept"


def worst(*runs: tuple[int, int, float, str]) -> list[report.WorstRun]:
    return [report.WorstRun(*run) for run in runs]


def test_the_worst_runs_by_their_distance_beyond_a_limit() -> None:
    """Bias may be from -2 to 3: 5 is 2 beyond; -1 is 1 within, and farther than 2.5, which is 0.5 within."""
    result = study_result(
        AGED + LIMITED, {"bias": [[-1, 1, 1], [1, 2.5, 1], [1, 3, 5], [-2, 0, 0]], "noise": [[1] * 3] * 4}
    )
    result = replace(result, numbers=np.array([10, 11, 12, 13]))
    assert report.worst_runs(result, "bias", 3) == worst(
        (12, 2, 5.0, "2 beyond its limit"), (13, 0, -2.0, "0 within its limit"), (11, 1, 2.5, "0.5 within its limit")
    )


def test_the_worst_runs_without_a_limit_are_those_farthest_from_the_median() -> None:
    """Of 1, 2, 9 and 1, 2, 2 the medians are 2 and 2; a run that failed at an age counts by its others."""
    result = study_result('epochs = { ages = ["0 h", "1 year"] }\n', {"bias": [[1, 1], [2, np.nan], [9, 2]]})
    assert report.worst_runs(result, "bias", 9) == worst(
        (2, 0, 9.0, "7 from the median"), (0, 0, 1.0, "1 from the median"), (1, 0, 2.0, "0 from the median")
    )


def test_distances_beyond_limits() -> None:
    """Inside they are negative; a change of 10 % counts from the second age, and the limit from there on."""
    values = np.array([[9.0, -1.0, -1.25], [0.0, 2.0, 3.0]])
    limit = Limit(at_least=-1.5, at_most=2.5, start=YEAR)
    ages = (0.0, YEAR, 2.0 * YEAR)
    np.testing.assert_array_equal(report._beyond(values, limit, ages), [[np.nan, -0.5, -0.25], [np.nan, -0.5, 0.5]])
    limit = replace(limit, change=0.5)
    np.testing.assert_array_equal(report._beyond(values, limit, ages), [[np.nan, -0.5, -0.25], [np.nan, -0.5, 0.5]])
    limit = replace(limit, at_least=-9.0, at_most=9.0, change=0.125)
    np.testing.assert_array_equal(report._beyond(values, limit, ages), [[np.nan, -0.125, 0.125], [np.nan, -0.25, 0.75]])


def test_the_first_runs_that_failed_are_named() -> None:
    result: Any = SimpleNamespace(faults={(3, 1): "a", (4, 0): "b", (9, 0): "c"})
    first, second = report.failed_runs(result, 2)
    assert (first.run, first.epoch, first.why) == (3, 1, "a")
    assert (second.run, second.epoch, second.why) == (4, 0, "b")
    assert math.isnan(first.value)
    assert len(report.failed_runs(result, 9)) == 3


def test_runs_to_look_at_begin_with_those_that_failed_and_what_misses_a_limit() -> None:
    values = {"noise": [[1.0, 2.0], [1.5, 2.0]], "bias": [[0.5, 0.5], [0.5, 3.25]]}
    result = study_result('epochs = { ages = ["0 h", "1 year"] }\nlimits = { bias = { at_most = 3 } }\n', values)
    result = replace(result, faults={(7, 1): "a wire broke"})
    replay = "proofmass montecarlo study.toml --run"
    assert numbers_of(report._worst(result)) == [1, 2, 3]
    assert rows_of(report._worst(result)) == [
        ["measure", "run", "age", "value", "", "to replay it"],
        ["failed", "7", "1 year", "", "a wire broke", f"{replay} 7 --epoch 1"],
        ["bias", "1", "1 year", "3.25", "0.25 beyond its limit", f"{replay} 1 --epoch 1"],
        ["bias", "0", "0 h", "0.5", "2.5 within its limit", f"{replay} 0"],
        ["noise", "0", "0 h", "1", "0.25 from the median", f"{replay} 0"],
        ["noise", "1", "0 h", "1.5", "0.25 from the median", f"{replay} 1"],
    ]
    many = study_result("", {"bias": [[float(k)] for k in range(8)]})
    rows = rows_of(report._worst(replace(many, faults={(k, 0): "" for k in range(12)})))
    assert [row[0] for row in rows[1:]] == ["failed"] * 10 + ["bias"] * 5
    nothing = {name: np.full((2, 2), np.nan) for name in values}
    assert report._worst(replace(result, values=nothing, faults={})) == "<p>No runs.</p>"


def test_commands_name_the_files_of_own_blocks_once_and_quote_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report, "own_file", {int: "b c.py", float: None, str: "a.py"}.__getitem__)
    blocks = {"one": 1, "two": 2, "three": 3.0, "four": "4"}
    result: Any = SimpleNamespace(study=SimpleNamespace(flat=SimpleNamespace(blocks=blocks)))
    command = "proofmass montecarlo study.toml --blocks a.py --blocks 'b c.py' --run 3"
    assert report._command(result, "--run", "3") == command


def facts_of(result: StudyResult) -> list[list[str]]:
    return rows_of(report._facts(result))


def test_facts_on_a_study() -> None:
    result = study_result("", {"bias": [[1.0]] * 1200})
    result = replace(result, planned_runs=2000, faults={(k, 0): "" for k in range(1001)})
    assert facts_of(result) == [
        ["design", "random"],
        ["runs", "1,200 of 2,000"],
        ["failed", "1,001"],
        ["time", "1.5 s"],
        ["SHA-256 of the values", result.digest],
        ["SHA-256 of the graph", "0123abcd"],
        ["proofmass", "0.1.0"],
        ["date", "2026-01-02"],
    ]
    assert "time" not in dict(facts_of(replace(result, seconds=0.0)))  # type: ignore[arg-type]
    assert "SHA-256 of the graph" not in dict(facts_of(replace(result, provenance={})))  # type: ignore[arg-type]


def test_what_repeats_a_study_is_a_command_and_its_file() -> None:
    text = report._repeat(study_result(SWEPT, {"bias": [[1.0]] * 2}))
    assert "<pre>proofmass montecarlo study.toml --out .</pre>" in text
    _, _, folded = text.partition("<summary>study.toml</summary>")
    assert "corner_frequency&quot; = [" in folded
    assert "seed = 11" in folded
