"""The table of a study as CSV and Parquet, read back by other readers, to the bit."""

import csv
import dataclasses
from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest

from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.command_line import main
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.whole.study import run_study
from tests.by_hand.study_texts import STUDY

HEAD = ["run", "epoch", "age [s]", "filter.corner_frequency [Hz]", "adc.reference [V]", "source.value [V]", "bias"]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path / "study.toml"


def test_every_number_is_there(path: Path, tmp_path: Path) -> None:
    command = ["montecarlo", str(path), "--engine", "python", "--out", str(tmp_path / "out")]
    assert main([*command, "--format", "csv", "--format", "parquet", "--no-report"]) == 0
    study = read_study(path)
    result = run_study(study, engine="python")
    with (tmp_path / "out" / "study.csv").open(newline="") as file:
        head, *rows = csv.reader(file)
    table = pyarrow.parquet.read_table(tmp_path / "out" / "study.parquet")
    assert head == [*HEAD, "noise", "fault"]
    assert table.column_names == [name.partition(" ")[0] for name in head]
    assert len(rows) == table.num_rows == 36
    for number, (row, entry) in enumerate(zip(rows, table.to_pylist(), strict=True)):
        run, epoch = divmod(number, 3)
        drawn = study.drawn(run)[epoch]
        expected = [run, epoch, study.epochs[epoch], *(drawn[name.partition(" ")[0]] for name in HEAD[3:6])]
        expected += [result["bias"][run, epoch], result["noise"][run, epoch], ""]
        assert list(entry.values()) == expected
        assert [float(text) for text in row[:-1]] == expected[:-1]
    field = table.schema.field("adc.reference")
    assert field.metadata[b"unit"] == b"V"
    assert table.schema.metadata[b"digest"].decode() == result.digest


def test_failed_runs_and_texts_with_commas(path: Path, tmp_path: Path) -> None:
    from proofmass.runner.studies.shown.export import save_study_csv, save_study_parquet

    result = failing(read_study(path))
    with save_study_csv(result, tmp_path / "a.csv").open(newline="") as file:
        rows = list(csv.reader(file))[1:]
    table = pyarrow.parquet.read_table(save_study_parquet(result, tmp_path / "a.parquet")).to_pylist()
    assert rows[5][-3:] == ["", "", 'a "wire", not a number\nat tick 3']
    assert (table[5]["bias"], table[5]["fault"]) == (None, rows[5][-1])
    assert table[4]["bias"] == float(rows[4][-3])


def failing(study: Study) -> StudyResult:
    result = run_study(study, runs=2, engine="python")
    values = {name: column.copy() for name, column in result.values.items()}
    for column in values.values():
        column[1, 2] = np.nan
    return dataclasses.replace(result, values=values, faults={(1, 2): 'a "wire", not a number\nat tick 3'})
