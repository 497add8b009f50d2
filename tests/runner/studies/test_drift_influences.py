"""What scatters a study that drifts and is calibrated, against closed models: changes since the last calibration."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
import xarray

from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study, read_study_text
from proofmass.runner.command_line import main
from proofmass.runner.studies.draws.drawn_table import DrawnTable
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.influences import StudyInfluences, index_rows
from proofmass.runner.studies.shown.sensitivities import regression
from proofmass.runner.studies.whole.study import run_study

YEAR = 31557600.0
# error = 2 a + b - offset, and a calibration keeps 2 a + b: at any later age error = 2 da + db, and nothing else.
CALIBRATED = """\
name = "an offset that a calibration takes off"
rate = "1 kHz"
samples = 1
wires = ["a.output -> twice.input", "twice.output -> raw.first", "b.output -> raw.second",
    "raw.output -> error.first", "offset.output -> error.second"]

[measures]
error = { signal = "error.output", statistic = "last" }
kept = { signal = "raw.output", statistic = "last" }

[blocks]
a = { kind = "Constant", value = 1 }
b = { kind = "Constant", value = 1 }
twice = { kind = "Gain", gain = 2 }
raw = { kind = "Sum" }
offset = { kind = "Constant", value = 0 }
error = { kind = "Difference" }

[study]
runs = 400
seed = 3

[study.spread]
"a.value" = { normal = "1 %", relative = true }
"b.value" = { normal = "1 %", relative = true }

[study.epochs]
every = "1 year"
until = "15 year"

[study.drift]
"a.value" = { ramp = "100 ppm/year", ramp_spread = "50 ppm/year", relative = true }
"b.value" = { random_walk = "20 ppm/sqrt(year)" }

[study.recalibration]
every = ["never", "2 year"]
carried = { "offset.value" = "kept" }
"""


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> StudyResult:
    path = tmp_path_factory.mktemp("drift") / "study.toml"
    path.write_text(CALIBRATED)
    return run_study(read_study(path))


def rows_of(result: StudyResult, every: float, epoch: int, measure: str = "error") -> dict[str, dict[str, float]]:
    return {
        row["factor"]: row
        for row in StudyInfluences(result).rows()
        if (row["recalibration_s"], row["epoch"], row["measure"]) == (every, epoch, measure)
    }


@pytest.mark.exhaustive
@pytest.mark.defect("S13", before="0.1 % explained at 15 years", after="all of it, by what has changed")
@pytest.mark.parametrize(("every", "since"), [(float("inf"), 0), (2.0 * YEAR, 14)])
def test_the_change_since_the_last_calibration_explains_a_calibrated_sensor(
    result: StudyResult, every: float, since: int
) -> None:
    rows = rows_of(result, every, 15)
    assert rows["change of a.value"]["explained"] == pytest.approx(1.0, abs=1e-12)
    assert rows["change of a.value"]["since_s"] == since * YEAR
    assert rows["change of a.value"]["slope"] == pytest.approx(2.0, rel=1e-9)
    assert rows["change of b.value"]["slope"] == pytest.approx(1.0, rel=1e-9)
    study, runs = result.study, result.numbers[result.numbers % 2 == (every != float("inf"))]
    change = np.array([at[15]["a.value"] - at[since]["a.value"] for at in map(study.drawn, runs.tolist())])
    assert rows["change of a.value"]["effect"] == pytest.approx(2.0 * change.std(ddof=1), rel=1e-9)
    for name in ("a.value", "b.value"):
        assert abs(rows[name]["effect"]) < 1e-9 * rows["change of b.value"]["effect"]
    named = sorted(rows, key=lambda name: -abs(rows[name]["effect"]))
    assert set(named[:2]) == {"change of a.value", "change of b.value"}


@pytest.mark.exhaustive
def test_at_a_calibration_changes_are_those_since_the_one_before(result: StudyResult) -> None:
    """The run that calibrates still has what the one before has left."""
    rows = rows_of(result, 2.0 * YEAR, 14)
    assert rows["change of a.value"]["since_s"] == 12.0 * YEAR
    assert rows["change of a.value"]["explained"] == pytest.approx(1.0, abs=1e-12)


@pytest.mark.exhaustive
def test_at_the_first_epoch_the_values_explain_it(result: StudyResult) -> None:
    rows = rows_of(result, 2.0 * YEAR, 0)
    assert set(rows) == {"a.value", "b.value"}
    assert rows["a.value"]["slope"] == pytest.approx(2.0, rel=1e-9)
    assert rows_of(result, 2.0 * YEAR, 15, "kept")["a.value"]["slope"] == pytest.approx(2.0, rel=1e-9)


@pytest.mark.defect("S852", before="the rounding of a ramp has an influence, with a slope of 4e11", after="no factor")
def test_a_change_that_all_sensors_have_in_common_is_no_factor() -> None:
    study = Study(
        read_study_text(CALIBRATED).graph,
        runs=50,
        spread={"a.value": {"normal": 0.1}, "b.value": {"normal": 0.1}},
        epochs={"ages": ["0 h", "1 year"]},
        drift={"a.value": {"logarithmic": 0.1, "onset": "1 year"}},
    )
    assert {row["factor"] for row in StudyInfluences(run_study(study)).rows()} == {"a.value", "b.value"}


def test_a_drift_without_spread_of_its_own_is_one_factor_with_the_value() -> None:
    study = Study(
        read_study_text(CALIBRATED).graph,
        runs=50,
        spread={"a.value": {"normal": 0.1}},
        epochs={"ages": ["0 h", "1 year"]},
        drift={"a.value": {"ramp": "1 %/year", "relative": True}},
    )
    made = run_study(study, engine="python")
    (row,) = [row for row in StudyInfluences(made).rows() if row["epoch"] == 1 and row["measure"] == "error"]
    assert row["factor"] == "a.value, change of a.value"
    assert row["effect"] == pytest.approx(made["error"][:, 1].std(ddof=1), rel=1e-9)
    assert not row["change"]


@pytest.mark.defect("S13", before="the cause split over three blocks, in fourth place", after="one factor, first")
def test_factors_that_move_together_are_one() -> None:
    """y = m1 + m2 - 0.5 m3 + 1.2 other, the three of them one mass."""
    dice = np.random.default_rng(5)
    mass, other = dice.normal(size=(2, 200))
    columns = {name: mass + 1e-3 * dice.normal(size=200) for name in ("drive", "sense", "coriolis")}
    y = columns["drive"] + columns["sense"] - 0.5 * columns["coriolis"] + 1.2 * other + 0.1 * dice.normal(size=200)
    found = regression({**columns, "other": other}, y)
    assert found is not None
    first, second = found.influences
    assert first.parameters == ("drive", "sense", "coriolis")
    assert first.effect == pytest.approx(1.5 * mass.std(ddof=1), rel=0.02)
    assert first.effect_half < 0.03
    assert second.parameter == "other"
    assert second.effect == pytest.approx(1.2 * other.std(ddof=1), rel=0.02)
    assert found.explained > 0.995


def test_opposite_effects_of_what_moves_together_are_seen() -> None:
    """y = a - b with r = 0.97: their mean says nothing about it."""
    dice = np.random.default_rng(6)
    a = dice.normal(size=500)
    b = 0.97 * a + np.sqrt(1.0 - 0.97**2) * dice.normal(size=500)
    found = regression({"a": a, "b": b}, a - b)
    assert found is not None
    assert found.explained == pytest.approx(1.0, abs=1e-12)
    assert abs(found.influences[0].effect) == pytest.approx((a - b).std(ddof=1), rel=1e-9)


def test_one_mass_in_three_blocks(result: StudyResult) -> None:
    names = ("a.value", "b.value")
    graph = result.study.graph
    study = Study(
        graph,
        runs=40,
        seed=2,
        spread={name: {"normal": 0.1} for name in (*names, "offset.value")},
        correlation={"a.value": {"b.value": 1.0}},
    )
    for drawn in map(study.drawn, range(40)):
        assert drawn[0]["a.value"] == drawn[0]["b.value"]
    rows = [row for row in StudyInfluences(run_study(study, engine="python")).rows() if row["measure"] == "error"]
    assert [row["factor"] for row in rows] == ["a.value, b.value", "offset.value"]
    deviation = np.std([study.drawn(run)[0]["a.value"] for run in range(40)], ddof=1)
    assert rows[0]["effect"] == pytest.approx(3.0 * deviation, rel=1e-9)


@pytest.mark.exhaustive
def test_sobol_indices_are_told_at_every_interval(result: StudyResult) -> None:
    spread = {"a.value": {"normal": 0.1}, "b.value": {"normal": 0.1}}
    more = {"epochs": {"ages": ["0 h", "1 year"]}, "recalibration": {"every": ["never", "1 year"]}}
    more["recalibration"]["carried"] = {"offset.value": "kept"}  # type: ignore[assignment]
    study = Study(result.study.graph, runs=4 * 64, design="saltelli", spread=spread, **more)
    rows = index_rows(run_study(study, engine="python"))
    assert {row["recalibration_s"] for row in rows} == {float("inf"), YEAR}
    kept = [row for row in rows if row["measure"] == "kept" and row["epoch"] == 1]
    for row in kept:
        assert row["first_order"] == pytest.approx({"a.value": 0.8, "b.value": 0.2}[row["parameter"]], abs=0.05)
    assert len(kept) == 4


def test_drawing_is_the_same_one_by_one_and_together(result: StudyResult, monkeypatch: pytest.MonkeyPatch) -> None:
    alone = DrawnTable(result.study, result.numbers[:50])
    values = [alone[column].tolist() for column in alone.columns]
    monkeypatch.setattr("proofmass.runner.studies.draws.drawn_table._ONE_BY_ONE", 0)
    together = DrawnTable(result.study, result.numbers[:50])
    assert values == [together[column].tolist() for column in together.columns]


@pytest.mark.exhaustive
@pytest.mark.defect("S13", before="tornado and drawn parameters only inside HTML", after="JSON, CSV, Parquet, netCDF")
def test_influences_and_parameters_are_data(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "study.toml").write_text(CALIBRATED.replace("runs = 400", "runs = 20"))
    out = tmp_path / "out"
    command = ["montecarlo", str(tmp_path / "study.toml"), "--engine", "python", "--out", str(out), "--quiet"]
    assert main([*command, "--format", "csv", "--format", "parquet", "--no-report"]) == 0
    assert not list(out.glob("influences.*"))
    assert not (out / "report.html").exists()
    assert main([*command, "--format", "csv", "--format", "parquet"]) == 0
    rows = json.loads((out / "influences.json").read_text())["rows"]
    with (out / "influences.csv").open(newline="") as file:
        texts = list(csv.DictReader(file))
    table = xarray.open_dataset(out / "influences.nc")
    assert len(rows) == len(texts) == table.sizes["row"]
    for row, text, factor in zip(rows, texts, table["factor"].values.tolist(), strict=True):
        assert row["factor"] == text["factor"] == factor
        assert row["effect"] == float(text["effect"])
    study = read_study(tmp_path / "study.toml")
    data = xarray.open_dataset(out / "study.nc")
    assert data["a.value"].dims == ("run", "epoch")
    assert data["a.value"].values.tolist() == [[at["a.value"] for at in study.drawn(run)] for run in range(40)]
    assert data["a.value"].attrs["units"] == "1"
    with (out / "study.csv").open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert [line["recalibration [s]"] for line in lines[:: len(study.epochs)]] == ["inf", repr(2.0 * YEAR)] * 20
    page = (out / "report.html").read_text()
    for words in ("change of a.value", "Changes are those since the last calibration, at 14 years", "100 %"):
        assert words in page
    capsys.readouterr()


@pytest.mark.exhaustive
@pytest.mark.defect("S13", before="inner.level.value in files and tables", after="as it is written")
def test_names_come_back_as_they_are_written(tmp_path: Path) -> None:
    graph = """\
name = "outer"
rate = "1 kHz"
samples = 1
wires = []
[measures]
last = { signal = "inner.level.output", statistic = "last" }
[blocks.inner]
exports = { scale = "level.value" }
blocks.level = { kind = "Constant", value = 1 }
[study]
runs = 10
spread = { "inner.scale" = { normal = 0.1 } }
sweep = { "inner.scale" = [1, 2] }
"""
    (tmp_path / "study.toml").write_text(graph)
    assert main(["montecarlo", str(tmp_path / "study.toml"), "--out", str(tmp_path / "out"), "--format", "csv"]) == 0
    data = xarray.open_dataset(tmp_path / "out" / "study.nc")
    assert "inner.scale" in data.coords
    assert "inner.level.value" not in data.coords
    assert (tmp_path / "out" / "study.csv").read_text().startswith("run,epoch,age [s],inner.scale,last,fault\n")
    assert '"inner.scale" = ' in (tmp_path / "out" / "study.toml").read_text()
    points = json.loads((tmp_path / "out" / "study.json").read_text())["points"]
    assert [point["sweep"] for point in points] == [{"inner.scale": 1.0}, {"inner.scale": 2.0}]
    assert "inner.level.value" not in (tmp_path / "out" / "report.html").read_text().partition("<pre>")[0]
    assert main(["report", str(tmp_path / "out")]) == 0
