"""The command `montecarlo`: table, files, JSON, replay, and mistakes without a traceback."""

import json
import sqlite3
from pathlib import Path

import numpy as np
import pytest
import xarray

from proofmass.graphs.studies.ages import age_text
from proofmass.runner.command_line import main
from proofmass.runner.studies.kept.folder import kept_result
from proofmass.runner.studies.whole.study import run_study
from tests.by_hand.study_texts import CALIBRATED, STUDY


@pytest.fixture
def study(tmp_path: Path) -> Path:
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    return path


@pytest.mark.exhaustive
@pytest.mark.friendly(25, "a study goes on")
@pytest.mark.friendly(32, "tables and files of a study")
def test_table_files_and_resuming(study: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["montecarlo", str(study), "--engine", "python", "--out", str(tmp_path / "out")]
    assert main(command) == 0
    said = capsys.readouterr()
    assert "12 runs at 3 epochs, python engine" in said.out
    for word in ("bias", "noise", "0 h", "1000 h", "1 year", "yield, all limits: "):
        assert word in said.out
    assert main([*command, "--json", "--no-report"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert (data["runs"], data["planned_runs"], data["interrupted"]) == (12, 12, False)
    opened = xarray.open_dataset(tmp_path / "out" / "study.nc", engine="h5netcdf")
    assert opened.attrs["digest"] == data["digest"]
    assert opened["bias"].shape == (12, 3)
    assert float(opened["bias"][:, 1].mean()) == pytest.approx(data["measures"][1]["mean"], rel=1e-14)
    opened.close()
    for name in ("study.svg", "study.png", "study.json", "ledger.sqlite"):
        assert (tmp_path / "out" / name).stat().st_size > 1000
    ledger = sqlite3.connect(tmp_path / "out" / "ledger.sqlite")
    held = b"".join(numbers for (numbers,) in ledger.execute("SELECT numbers FROM stretches ORDER BY first"))
    ledger.close()
    bias = np.frombuffer(held).reshape(12, 3, 2)[:, 1, 0]
    assert bias.mean() == pytest.approx(data["measures"][1]["mean"])


AT_A_CORNER = """\
name = "a loop at a corner"
rate = "1 kHz"
samples = 20
wires = [
    "bias.output -> sum.first", "late.output -> sum.second", "sum.output -> x.input", "x.output -> both.first",
    "sum.output -> both.second", "both.output -> back.input", "back.output -> late.input",
]
loops.main.open_at = "back.output"
study = { runs = 4, margins = "0 s", spread = { "back.gain" = { uniform = 0.01 } } }

[blocks]
bias = { kind = "Constant", value = 0 }
sum = { kind = "Sum" }
x = { kind = "DeadZone", lowest = -1, highest = 0.0 }
both = { kind = "Sum" }
back = { kind = "Gain", gain = -0.05 }
late = { kind = "UnitDelay" }
"""


@pytest.mark.defect("S910", before="margins of one side of a corner, without a word", after="a note names the block")
@pytest.mark.parametrize(("edge", "said"), [("0.0", True), ("0.1", False)])
def test_margins_about_a_corner_have_a_note(
    edge: str, said: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "corner.toml"
    path.write_text(AT_A_CORNER.replace("highest = 0.0", f"highest = {edge}"))
    assert main(["montecarlo", str(path), "--quiet"]) == 0
    shown = capsys.readouterr().err
    assert ("corner.toml:8: note: loops.main: x stands exactly at a corner" in shown) == said


@pytest.mark.defect("S963", before="no word of the corner in Python", after="the notes of the result have it")
@pytest.mark.parametrize(("edge", "said"), [("0.0", True), ("0.1", False)])
def test_the_result_in_python_has_the_notes_of_the_command(edge: str, said: bool, tmp_path: Path) -> None:
    path = tmp_path / "corner.toml"
    path.write_text(AT_A_CORNER.replace("highest = 0.0", f"highest = {edge}"))
    notes = run_study(path, engine="python").notes
    told = [note.partition(": ")[2] for note in notes]
    assert [note.partition(": its slope")[0] for note in told] == [
        "note: loops.main: x stands exactly at a corner"
    ] * said


@pytest.mark.defect("H895", before="`check` has no word of a corner that the study has", after="the same notes")
def test_check_has_the_notes_of_a_study(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "corner.toml"
    path.write_text(AT_A_CORNER)
    assert main(["check", str(path)]) == 0
    assert "corner.toml:8: note: loops.main: x stands exactly at a corner" in capsys.readouterr().out


@pytest.mark.defect("S1004", before="a study read back from its folder had no notes", after="those of its run")
def test_a_study_that_is_read_back_has_its_notes(tmp_path: Path) -> None:
    path = tmp_path / "corner.toml"
    path.write_text(AT_A_CORNER)
    ran = run_study(path, engine="python", folder=tmp_path / "out")
    told = [note.partition("note: ")[2] for note in kept_result(tmp_path / "out").notes]
    assert told == [note.partition("note: ")[2] for note in ran.notes]
    assert told[0].startswith("loops.main: x stands exactly at a corner")


@pytest.mark.friendly(34, "by one option")
def test_replay_of_a_run(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["montecarlo", str(study), "--engine", "python", "--json"]
    assert main([*command, "--run", "3", "--epoch", "2"]) == 0
    replayed = json.loads(capsys.readouterr().out)
    assert [signal["signal"] for signal in replayed["signals"]] == ["adc.code"]
    assert set(replayed["measures"]) == {"bias", "noise"}
    assert main([*command, "--run", "12"]) == 1
    assert "expected: 0 to 11" in capsys.readouterr().err


def test_one_epoch_and_no_limits_draw_a_histogram(study: Path, tmp_path: Path) -> None:
    text = STUDY.partition("[study.sweep]")[0]
    study.write_text(text)
    assert main(["montecarlo", str(study), "--runs", "5", "--engine", "python", "--out", str(tmp_path / "out")]) == 0
    assert "runs" in (tmp_path / "out" / "study.svg").read_text()


@pytest.mark.exhaustive
def test_intervals_between_calibrations_have_tables_of_their_own(
    study: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study.write_text(CALIBRATED.replace('until = "4 year"', 'until = "40 year"'))
    command = ["montecarlo", str(study), "--runs", "2", "--engine", "python", "--out", str(tmp_path / "out")]
    assert main(command) == 0
    said = capsys.readouterr().out
    said, _, against = said.partition("against never recalibrated, sensor by sensor, at 40 years:")
    assert against.count("found") == 2
    tables = said.split("recalibrated")
    assert [table.count("found") for table in tables] == [0, 11, 11, 11]  # of 41 epochs
    assert "0 h" in tables[1]
    assert "40 years" in tables[1]
    assert "36 years" in tables[1]
    assert "every 2 years:" in tables[2]
    assert main([*command, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert [part["every_s"] for part in data["points"]] == [None, 2 * 31557600.0, 31557600.0]
    assert len(data["points"][0]["measures"]) == len(data["measures"]) == 2 * 41
    opened = xarray.open_dataset(tmp_path / "out" / "study.nc", engine="h5netcdf")
    assert opened["recalibration"].values.tolist() == [float("inf"), 2 * 31557600.0, 31557600.0] * 2
    opened.close()


@pytest.mark.friendly(32, "a mistake in a study is a message")
def test_a_mistake_is_a_message(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study.write_text(STUDY.replace("normal", "nromal"))
    assert main(["montecarlo", str(study)]) == 1
    said = capsys.readouterr().err
    assert "did you mean normal?" in said
    assert "Traceback" not in said


def test_ages_in_words() -> None:
    assert [age_text(age) for age in (0.0, 3.6e6, 315576000.0)] == ["0 h", "1000 h", "10 years"]
