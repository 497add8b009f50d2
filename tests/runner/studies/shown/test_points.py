"""Points of a study: told apart in what is said and drawn, as long as they are few."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.runner.command_line import main
from proofmass.runner.commands.study_files import study_data as as_json
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.plot import plot_study
from proofmass.runner.studies.shown.points import MOST_POINTS, by_point, parts, point_text, swept_parts
from proofmass.runner.studies.shown.report import save_study_report
from proofmass.runner.studies.whole.study import run_study
from tests.by_hand.study_texts import CALIBRATED, STUDY

GRID = STUDY.replace('["100 Hz", "200 Hz"]', '["100 Hz", "200 Hz"]\n"source.value" = ["1 V", "1500 mV", "2 V"]')
GRID = GRID.replace('"source.value" = { uniform = "1 mV" }\n', "")


@pytest.fixture(scope="module")
def result() -> StudyResult:
    return run_study(read_study_text(GRID), runs=4, engine="python")


def test_points_are_called_by_their_values(result: StudyResult) -> None:
    corners, sources = ("100 Hz", "200 Hz"), ("1 V", "1.5 V", "2 V")
    names = [f"filter.corner_frequency = {corner}, source.value = {source}" for corner in corners for source in sources]
    assert list(parts(result)) == names
    both = CALIBRATED.replace("[study.drift]", '[study.sweep]\n"source.value" = [1, 2]\n[study.drift]')
    assert point_text(read_study_text(both), 4) == "source.value = 2, recalibrated every 2 years"
    assert point_text(read_study_text(STUDY.partition("[study.sweep]")[0]), 0) == ""


def test_each_point_has_its_own_runs(result: StudyResult) -> None:
    failed = dataclasses.replace(result, faults={(7, 0): "lost", (8, 1): "lost too"})
    for point, part in enumerate(by_point(failed)):
        assert part.numbers.tolist() == list(range(point, 24, 6))
        assert part["bias"].tolist() == result["bias"][point::6].tolist()
        assert part.faults == {1: {(7, 0): "lost"}, 2: {(8, 1): "lost too"}}.get(point, {})
        assert part.planned_runs == 4
    assert sum(len(part.numbers) for part in swept_parts(result).values()) == 24
    early = dataclasses.replace(result, numbers=result.numbers[:2], values={n: v[:2] for n, v in result.values.items()})
    assert list(parts(early)) == list(parts(result))[:2]


@pytest.mark.parametrize(("swept", "shown"), [(1, 1), (2, 2), (MOST_POINTS + 1, 1)])
def test_intervals_between_calibrations_stay_together(swept: int, shown: int) -> None:
    """Under the value of the sweep, as long as there are few values."""
    table = f'[study.sweep]\n"source.value" = {list(range(1, swept + 1))}\n'
    result = run_study(
        read_study_text(CALIBRATED.replace("[study.drift]", f"{table}[study.drift]")), runs=1, engine="python"
    )
    found = swept_parts(result)
    names = [f"source.value = {value}" for value in range(1, swept + 1)]
    assert list(found) == (names if shown > 1 else [""])
    numbers = [part.numbers.tolist() for part in found.values()]
    assert numbers == [list(range(3 * swept // shown * at, 3 * swept // shown * (at + 1))) for at in range(shown)]


@pytest.mark.exhaustive
def test_the_command_and_the_report_tell_them_apart(
    result: StudyResult, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "study.toml").write_text(GRID)
    command = ["montecarlo", str(tmp_path / "study.toml"), "--runs", "4", "--engine", "python"]
    assert main(command) == 0
    said = capsys.readouterr().out
    assert main([*command, "--json"]) == 0
    points = json.loads(capsys.readouterr().out)["points"]
    page = save_study_report(result, tmp_path / "report.html").read_text()
    assert [point["sweep"]["source.value"] for point in points] == [1.0, 1.5, 2.0] * 2
    for (name, part), point in zip(parts(result).items(), points, strict=True):
        assert f"\n{name}:\n" in said
        assert page.count(f"<h3>{name}</h3>") == 5
        assert point["measures"][0]["mean"] == part.summary()[0]["mean"]


def test_points_without_runs_are_left_out_of_the_data(result: StudyResult) -> None:
    """As where workers brought later runs first, and the study was interrupted."""
    late = dataclasses.replace(
        result, numbers=result.numbers[1:3], values={n: v[1:3] for n, v in result.values.items()}
    )
    assert [point["sweep"]["source.value"] for point in as_json(late)["points"]] == [1.5, 2.0]


def test_one_point_is_drawn_with_its_percentiles() -> None:
    head, _, rest = STUDY.partition("[study.sweep]")
    result = run_study(read_study_text(head + rest[rest.index("[study.epochs]") :]), engine="python")
    drawn = [text.get_text() for text in plot_study(result).legends[0].get_texts()]
    assert drawn[:4] == ["1 to 99 %", "10 to 90 %", "25 to 75 %", "median"]


@pytest.mark.exhaustive
@pytest.mark.defect("S603", before="limits about the median: most sensors seem to fail", after="each sensor's change")
def test_a_limited_change_is_drawn_as_the_change() -> None:
    head, _, rest = STUDY.partition("[study.sweep]")
    result = run_study(read_study_text(head + rest[rest.index("[study.epochs]") :]), engine="python")
    (name, limit) = next((name, limit) for name, limit in result.study.limits.items() if np.isfinite(limit.change))
    (panel,) = [panel for panel in plot_study(result).axes if panel.get_ylabel() == f"change of {name} [%]"]
    (median,) = [line for line in panel.lines if line.get_label() == "median"]
    own = result[name] / result[name][:, :1] - 1.0
    np.testing.assert_allclose(np.array(median.get_ydata(), dtype=float), 100.0 * np.median(own, axis=0), atol=1e-12)
    limits = sorted(float(np.array(line.get_ydata())[0]) for line in panel.lines if line.get_label() == "limit")
    assert limits in ([], [-100.0 * limit.change, 100.0 * limit.change])


@pytest.mark.exhaustive
def test_points_are_drawn_beside_each_other() -> None:
    figure = plot_study(run_study(read_study_text(STUDY), engine="python"))
    titles = [f"filter.corner_frequency = {corner} Hz" for corner in (100, 200)]
    assert [panel.get_title() for panel in figure.axes] == [*titles, "", "", "", ""]


@pytest.mark.exhaustive
def test_many_points_are_seen_together(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    values = [1.0 + number / 100 for number in range(MOST_POINTS + 1)]
    (tmp_path / "study.toml").write_text(STUDY.replace('["100 Hz", "200 Hz"]', str([100 * value for value in values])))
    command = ["montecarlo", str(tmp_path / "study.toml"), "--runs", "1", "--engine", "python"]
    assert main([*command, "--out", str(tmp_path / "out")]) == 0
    assert "all 13 points of the sweep together" in capsys.readouterr().out
    assert "All 13 points of the sweep together" in (tmp_path / "out" / "report.html").read_text()
