"""Sizes of recordings: how many rows may be read, how much memory that takes, and what is kept of a file."""

import os
import tracemalloc
from pathlib import Path
from typing import Any

import h5netcdf
import numpy as np
import pyarrow
import pyarrow.parquet
import pytest

from proofmass.runner.plan.recording import MOST_ROWS, read_columns
from tests.runner.plan.test_recording import (
    classic_netcdf_file,
    csv_file,
    netcdf_file,
    parquet_file,
    problem_of,
    read,
)


def test_a_file_beyond_two_gibibytes_is_refused_unread(tmp_path: Path) -> None:
    with (tmp_path / "log.csv").open("wb") as file:
        file.truncate((2 << 30) + 1)
    assert problem_of(tmp_path / "log.csv").message == "is larger than 2 GiB"


@pytest.mark.defect("H400", before="a file of 0.1 MB takes gigabytes and does not end", after="refused unread")
@pytest.mark.parametrize("form", ["parquet", "nc"])
def test_more_rows_than_may_be_are_refused_before_they_are_read(form: str, tmp_path: Path) -> None:
    zeros, path = np.zeros(MOST_ROWS + 1), tmp_path / f"log.{form}"
    if form == "parquet":
        pyarrow.parquet.write_table(pyarrow.table({"time": zeros, "level": zeros}), path)
    else:
        with h5netcdf.File(path, "w") as file:
            file.dimensions["time"] = MOST_ROWS + 1
            for name in ("time", "level"):
                file.create_variable(name, ("time",), "f8", chunks=(1 << 20,), compression="gzip")
    del zeros
    assert path.stat().st_size < 1 << 20
    tracemalloc.start()
    problem = problem_of(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert problem.message == "has more than 16,777,216 rows"
    assert peak < 8 << 20


@pytest.mark.exhaustive
@pytest.mark.parametrize("form", ["csv", "parquet", "nc", "classic"])
def test_columns_take_at_most_twice_their_file(form: str, tmp_path: Path) -> None:
    rows = 100_000
    times, values = np.arange(rows) / 1000.0, np.random.default_rng(1).normal(size=rows)
    if form == "csv":
        lines = (f"{t!r},{v!r}\n" for t, v in zip(times.tolist(), values.tolist(), strict=True))
        path = csv_file(tmp_path, "time [s],level\n" + "".join(lines))
    elif form == "parquet":
        path = parquet_file(tmp_path, {"time": times, "level": values})
    else:
        made = netcdf_file if form == "nc" else classic_netcdf_file
        path = made(tmp_path, {"time": ("time", times, {}), "level": ("time", values, {})})
    tracemalloc.start()
    columns = read_columns(path, lambda names: (0, 1))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert np.array_equal(columns[1].values, values)
    assert peak < 2 * path.stat().st_size + (8 << 20)  # beside a piece of Python numbers


def test_a_csv_is_read_again_when_its_content_is_another(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the same name, size and, as far as the file system knows, time."""
    from proofmass.runner.plan import recording

    parsed = list[Path]()
    once = recording.read_columns

    def counted(path: Path, choice: Any) -> Any:
        parsed.append(path)
        return once(path, choice)

    monkeypatch.setattr(recording, "read_columns", counted)
    path = csv_file(tmp_path, "time,a\n0,1.25\n")
    assert [read(path)[1] for _ in range(3)] == [[1.25]] * 3
    assert len(parsed) == 1
    stamps = path.stat()
    csv_file(tmp_path, "time,a\n0,1.75\n")
    os.utime(path, ns=(stamps.st_atime_ns, stamps.st_mtime_ns))
    assert read(path)[1] == [1.75]
    assert read(path, unit="V")[1] == [1.75]
    assert len(parsed) == 3


def test_no_more_numbers_are_kept_than_may_be(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from proofmass.runner.plan import recording

    monkeypatch.setattr(recording, "KEPT_NUMBERS", 8)
    monkeypatch.setattr(recording, "_kept", {})
    for value in range(5):
        read(csv_file(tmp_path, f"time,a\n0,1\n1,{value}\n"))
        assert sum(2 * len(entry["time"]) for entry in recording._kept.values()) <= 8
    assert len(recording._kept) == 2
