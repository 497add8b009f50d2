"""Recordings: dialects of CSV, units, gaps, missing values, times, other sources; each handled as stated or refused."""

import os
from array import array
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.design.identification import tables
from proofmass.runner.design.identification.recordings import Gaps, RecordedStretch, Wanted, recordings_of
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.plan.recording import Column, RecordingError

INPUTS, OUTPUTS = [Wanted("force.output", "force", "N")], [Wanted("seen.output", "volts", "V")]
ROWS = [(0.1 * k, 0.5 * k, 1.5 - 0.1 * k) for k in range(10)]


def text(head: str, separator: str = ",", decimal: str = ".", rows: list[tuple[float, ...]] = ROWS) -> str:
    lines = [separator.join(f"{v:.4f}".replace(".", decimal) for v in row) for row in rows]
    return "\n".join([head, *lines]) + "\n"


def read(folder: Path, content: str, gaps: Gaps = "refuse") -> tuple[list[RecordedStretch], list[str]]:
    path = folder / "record.csv"
    path.write_text(content, encoding="utf-8")
    return recordings_of(path, INPUTS, OUTPUTS, gaps)


@pytest.mark.parametrize(
    ("content", "note"),
    [
        (text("time [s],force [N],volts [V]"), ""),
        (text("time [s];force [N];volts [V]", ";"), "separated by semicolons"),
        (text("time [s];force [N];volts [V]", ";", ","), "decimal comma"),
        (text("time\tforce\tvolts", "\t"), "separated by tabs"),
        (text("time force volts", " "), "separated by blanks"),
        ("\ufeff# a comment\n" + text("time,force,volts"), ""),
        (text("time,force,volts\ns,N,V"), "taken for units"),
        (text("time [ms],force [uN],volts [mV]", rows=[(1e3 * t, 1e6 * f, 1e3 * v) for t, f, v in ROWS]), ""),
        (text("time,force,volts", rows=[(t + 7.0, f, v) for t, f, v in ROWS]), "starts at 7 s"),
        (text("time [s],other,volts,force", rows=[(t, 9.0, v, f) for t, f, v in ROWS]), ""),
    ],
)
def test_dialects_units_and_starts(tmp_path: Path, content: str, note: str) -> None:
    (recording,), notes = read(tmp_path, content)
    assert recording.times == pytest.approx([row[0] for row in ROWS])
    assert recording.inputs["force.output"] == pytest.approx([row[1] for row in ROWS])
    assert recording.outputs["seen.output"] == pytest.approx([row[2] for row in ROWS])
    assert note in " ".join(notes)
    assert "10 rows, 0.9 s at 10 Hz" in notes[-1]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (text("time,force,volts,volts", rows=[(*row, 0.0) for row in ROWS]), "has 2 columns 'volts'"),
        (text("time,force,bolts"), "did you mean bolts"),
        (text("time [s],force [N],volts [m]"), "unit that does not fit"),
        (text("time,force,volts", rows=[*ROWS[:5], ROWS[3], *ROWS[5:]]), "time does not grow"),
        (text("time,force,volts", rows=[*ROWS[:5], ROWS[4], *ROWS[5:]]), "time does not grow"),
        (text("time,force,volts", rows=[*ROWS[:3], *ROWS[6:], *[(1.0 + k, 0.0, 0.0) for k in range(5)]]), "has 5 gaps"),
        (text("time,force,volts").replace("0.5000", "nan", 1), "the input force misses 1 of 10"),
        (text("time,force,volts").replace("0.5000", "half", 1), "holds 'half', which is not a number"),
        (text("time,force,volts") + "1.0,2.0\n", "has 2 cells where the head has 3"),
        (text("time,force,volts", rows=ROWS[:3]), "too few rows"),
        ("0,1,2\n1,2,3\n", "row of column names"),
        ("", "holds no rows"),
        ("time,force,volts\n", "holds no rows"),
    ],
)
def test_what_cannot_be_known_is_refused(tmp_path: Path, content: str, words: str) -> None:
    with pytest.raises(ModelError) as told:
        read(tmp_path, content)
    assert words in str(told.value.problems[0])
    assert "record.csv" in str(told.value.problems[0])


def test_a_recording_is_cut_at_its_gaps_if_that_is_wanted(tmp_path: Path) -> None:
    rows = [*ROWS, *[(t + 5.0, f, v) for t, f, v in ROWS], (20.0, 0.0, 0.0)]
    pieces, notes = read(tmp_path, text("time,force,volts", rows=rows), "split")
    assert [len(piece.times) for piece in pieces] == [10, 10]
    assert pieces[1].times[0] == 0.0
    assert "a piece of 1 rows at 20 s is left out" in " ".join(notes)


def test_missing_outputs_are_not_compared(tmp_path: Path) -> None:
    (recording,), notes = read(tmp_path, text("time,force,volts").replace("1.5000", "", 1))
    assert np.isnan(recording.outputs["seen.output"][0])
    assert "1 of 10 values of volts are missing" in " ".join(notes)


def test_arrays_and_datasets_are_recordings_too() -> None:
    time, force, volts = np.array(ROWS).T
    tables = [
        {"time": time, "force": force, "volts": volts},
        xarray.Dataset(
            {"force": ("t", 1e3 * force, {"units": "mN"}), "volts": ("t", volts)}, coords={"t": ("t", time)}
        ),
    ]
    for recording in recordings_of(tables, INPUTS, OUTPUTS, "refuse")[0]:
        assert recording.inputs["force.output"] == pytest.approx(force)
    for wrong in ({"time": time, "force": force[1:], "volts": volts}, 3, {}):
        with pytest.raises(ModelError):
            recordings_of([wrong], INPUTS, OUTPUTS, "refuse")


def test_a_step_of_one_and_a_half_is_no_gap_and_a_longer_one_is(tmp_path: Path) -> None:
    """Times in halves of a second, which are exact."""
    for late, is_gap in ((0.5, False), (0.5625, True)):
        rows = [(float(k) if k < 10 else k + late, 0.5, 1.5) for k in range(20)]
        stretches, _ = read(tmp_path, text("time [s],force [N],volts [V]", rows=rows), "split")
        assert [len(stretch.times) for stretch in stretches] == ([10, 10] if is_gap else [20])


@pytest.mark.parametrize(
    ("time", "force"),
    [(np.zeros(4), np.zeros(3)), (np.zeros((4, 1)), np.zeros((4, 1))), (np.zeros(4), np.zeros((4, 1)))],
)
def test_arrays_of_other_lengths_and_of_two_axes_are_refused(time: np.ndarray, force: np.ndarray) -> None:
    data = {"force": force, "volts": np.zeros(4) if time.ndim == 1 else time, "time": time}
    with pytest.raises(ModelError, match="its arrays are not of one length") as error:
        recordings_of(data, INPUTS, OUTPUTS, "refuse")
    assert f"force {force.shape}" in (error.value.problems[0].got or "")


def test_times_may_stand_anywhere_under_their_name_or_first_under_another() -> None:
    time, force, volts = (np.array(column) for column in zip(*ROWS, strict=True))
    for data in ({"force": force, "volts": volts, "time": time}, {"t": time, "volts": volts, "force": force}):
        (stretch,), _ = recordings_of(data, INPUTS, OUTPUTS, "refuse")
        assert stretch.times.tolist() == pytest.approx(time)
        assert stretch.inputs["force.output"].tolist() == force.tolist()


def test_a_file_larger_than_two_gibibytes_is_refused(tmp_path: Path) -> None:
    """It has no content, only a size."""
    path = tmp_path / "large.txt"
    path.touch()
    os.truncate(path, 2**31 + 1)
    with pytest.raises(ModelError, match="is larger than 2 GiB"):
        recordings_of(path, INPUTS, OUTPUTS, "refuse")


@pytest.mark.parametrize("rows", [3, 2])
def test_columns_of_one_file_have_one_time_axis(rows: int, monkeypatch: pytest.MonkeyPatch) -> None:
    def read_columns(path: Path, choice: Any) -> tuple[Column, Column]:
        at, column = choice(["time", "force", "volts"])
        assert at == 0
        last = rows if column == 2 else 3
        names = ("time", "force", "volts")
        return Column("time", "s", array("d", range(3))), Column(names[column], "V", array("d", range(last)))

    monkeypatch.setattr(tables, "read_columns", read_columns)
    if rows == 3:
        found = tables._read_pairs(Path("a.nc"), ["force", "volts"])
        for name in ("time", "force", "volts"):
            assert found.columns[name].tolist() == [0.0, 1.0, 2.0]
        return
    with pytest.raises(RecordingError, match="column volts has a time axis of its own"):
        tables._read_pairs(Path("a.nc"), ["force", "volts"])


TIME, FORCE, VOLTS = (np.array(column) for column in zip(*ROWS, strict=True))


def taken(data: object) -> RecordedStretch:
    (stretch,), _ = recordings_of(data, INPUTS, OUTPUTS, "refuse")
    return stretch


@pytest.mark.defect("S921", before="times along the first axis of a dataset, here 5 s apart", after="their own")
def test_variables_of_a_dataset_have_the_times_of_their_own_axis() -> None:
    dataset = xarray.Dataset(
        {"other": ("slow", 9.0 + TIME), "force": ("t", FORCE), "volts": ("t", VOLTS)},
        coords={"slow": 50.0 * TIME, "t": TIME},
    )
    assert taken(dataset).times == pytest.approx(TIME)


@pytest.mark.defect("S921", before="rows without times were taken for seconds, and two axes an error", after="refused")
@pytest.mark.parametrize(
    ("volts", "words"), [("t", "has no times along t"), ("slow", "not along one axis"), (("t", "k"), "not along one")]
)
def test_datasets_without_one_axis_of_times_are_refused(volts: Any, words: str) -> None:
    values = VOLTS if isinstance(volts, str) else VOLTS[:, np.newaxis]
    dataset = xarray.Dataset({"force": ("t", FORCE), "volts": (volts, values)})
    with pytest.raises(ModelError, match=words):
        taken(dataset)


NANOSECONDS = (1e9 * TIME).round().astype("timedelta64[ns]")


@pytest.mark.parametrize("times", [NANOSECONDS, np.datetime64("2026-03-01T12:00:00.000000000") + NANOSECONDS])
@pytest.mark.defect("S922", before="times of 0.1 s steps were 1e8 s apart: nanoseconds as seconds", after="0.1 s")
def test_times_that_are_no_numbers_are_in_seconds(times: AnyArray) -> None:
    dataset = xarray.Dataset({"force": ("t", FORCE), "volts": ("t", VOLTS)}, coords={"t": times})
    for data in ({"time": times, "force": FORCE, "volts": VOLTS}, dataset):
        assert taken(data).times == pytest.approx(TIME, abs=1e-9)


@pytest.mark.defect("S923", before="arrays under 'time [ms]' were in seconds", after="converted, as heads of files")
def test_names_of_arrays_have_units_as_heads_of_files_have() -> None:
    stretch = taken({"force [mN]": 1e3 * FORCE, "volts (uV)": 1e6 * VOLTS, "time [ms]": 1e3 * TIME})
    assert stretch.times == pytest.approx(TIME)
    assert stretch.inputs["force.output"] == pytest.approx(FORCE)
    assert stretch.outputs["seen.output"] == pytest.approx(VOLTS)
    with pytest.raises(ModelError, match="has 2 columns 'volts'"):
        taken({"time": TIME, "force": FORCE, "volts [V]": VOLTS, "volts [mV]": VOLTS})


@pytest.mark.defect("S924", before="masked values were compared, and 1 + 1j was 1", after="left out, and refused")
def test_masked_values_are_missing_and_complex_ones_are_refused() -> None:
    masked = np.ma.masked_array(np.where(TIME < 0.05, 1e20, VOLTS), mask=TIME < 0.05)
    assert np.isnan(taken({"time": TIME, "force": FORCE, "volts": masked}).outputs["seen.output"]).tolist() == [
        True, *[False] * 9
    ]  # fmt: skip
    for wrong, words in ((VOLTS + 1j, "holds complex numbers"), (np.array(["half"] * 10), "is not a number")):
        with pytest.raises(ModelError, match=words):
            taken({"time": TIME, "force": FORCE, "volts": wrong})
