"""What is written reads back exactly, whole or not at all."""

import csv
import dataclasses
import json
import math
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet
import pytest
import xarray

from proofmass.blocks import Constant, RecordedSignal
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.graph import Place
from proofmass.runner.commands.answers import write_or_print
from proofmass.runner.commands.schema_command import write_schema_file
from proofmass.runner.output import export
from proofmass.runner.output.export import save_csv, save_netcdf, save_parquet, save_summary, whole_file, write_whole
from proofmass.runner.plan.memory import start
from proofmass.runner.planning.plan import plan
from proofmass.runner.run import result as result_module
from proofmass.runner.run.checkpoint import save_checkpoint
from proofmass.runner.run.recorder import Recorder
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import simulate
from tests.by_hand.little_disk import largest_file
from tests.by_hand.results import GRAPH, made_result, made_trace, mixed_result

HARD = [0.0, -0.0, 5e-324, 1 / 3, 1.7976931348623157e308, -2.2250738585072014e-308, 0.1 + 0.2, 1e22]

SAVERS: dict[str, Callable[[Result, Path], Any]] = {
    "nc": lambda result, folder: save_netcdf(result, folder / "traces.nc"),
    "csv": save_csv,
    "parquet": save_parquet,
    "json": lambda result, folder: save_summary(result, folder / "traces.json"),
}


def read_csv(path: Path) -> tuple[list[str], list[list[str]]]:
    head, *rows = csv.reader(path.read_text().splitlines())
    return head, rows


@pytest.mark.parametrize("piece", [1 << 20, 5])
@pytest.mark.friendly(26, "units, seed and versions stand in the file")
@pytest.mark.friendly(27, "netCDF opens in xarray")
def test_netcdf_opens_in_xarray_as_the_result_itself(
    piece: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(result_module, "PIECE", piece)
    result = mixed_result()
    path = save_netcdf(result, tmp_path / "run.nc")
    with xarray.open_dataset(path, engine="h5netcdf") as data:
        xarray.testing.assert_identical(data.load(), result.to_xarray())
        assert data["bits.bit"].dtype == bool
        assert data["adc.code"].dtype == np.int64


def test_netcdf_holds_long_texts_empty_docs_and_no_rows(tmp_path: Path) -> None:
    result = made_result(
        [made_trace("adc.code", np.zeros(0, dtype=int), doc="")], provenance={"note": "long\n" * 40_000}
    )
    with xarray.open_dataset(save_netcdf(result, tmp_path / "run.nc")) as data:
        assert data.sizes == {"time": 0}
        assert len(data.attrs["note"]) == 200_000
        assert data["adc.code"].attrs["long_name"] == ""


@pytest.mark.friendly(27, "CSV has names, units and exact numbers")
def test_csv_says_names_and_units_and_every_number_exactly(tmp_path: Path) -> None:
    result = made_result([made_trace("sine.output", HARD, "V"), made_trace("bits.bit", np.arange(8) % 2 == 1)])
    (path,) = save_csv(result, tmp_path)
    assert path.read_text().splitlines()[:3] == [
        "time [s],sine.output [V],bits.bit [1]",
        "0.0,0.0,0",
        "2e-05,-0.0,1",
    ]
    _, rows = read_csv(path)
    assert [float(row[1]).hex() for row in rows] == [value.hex() for value in HARD]
    assert [float(row[0]) for row in rows] == result["sine.output"].times.tolist()


def test_csv_has_a_file_per_axis_and_a_column_per_entry(tmp_path: Path) -> None:
    result = mixed_result()
    paths = save_csv(result, tmp_path / "new" / "folder")
    assert [path.name for path in paths] == ["traces.csv", "traces_2.csv"]
    head, rows = read_csv(paths[1])
    entries = [f"cells.sums[{i}] [V/s]" for i in range(4)]
    assert head == ["time [s]", "adc.code [1]", *entries]
    assert [[int(cell) for cell in row[2:]] for row in rows] == result["cells.sums"].values.tolist()
    assert [int(row[1]) for row in rows] == result["adc.code"].values.tolist()  # beyond the 53 bits of a float


def test_csv_of_a_long_run_is_refused_before_anything_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(export, "LARGEST_CSV", 100)
    with pytest.raises(ModelError) as caught:
        save_csv(mixed_result(), tmp_path)
    assert str(caught.value) == (
        "probes: the traces are too long for CSV\n"
        "  got:      180 numbers\n"
        "  expected: at most 1e+02 numbers in a file\n"
        "  hint:     write netCDF or Parquet, or record one row in many: { signal = ..., every = 10 }"
    )
    assert not list(tmp_path.iterdir())


@pytest.mark.friendly(27, "Parquet has types and units")
def test_parquet_has_types_units_and_what_the_run_was_made_with(tmp_path: Path) -> None:
    result = mixed_result()
    paths = save_parquet(result, tmp_path)
    assert [path.name for path in paths] == ["traces.parquet", "traces_2.parquet"]
    table = pyarrow.parquet.read_table(paths[0])
    assert [str(kind) for kind in table.schema.types] == ["double", "double", "bool"]
    assert table.schema.field("sine.output").metadata[b"unit"] == b"V"
    assert table.schema.field("sine.output").metadata[b"doc"] == b"The sine wave."
    assert table.schema.field("time").metadata[b"unit"] == b"s"
    assert table.schema.metadata[b"seed"] == b"7"
    assert table.schema.metadata[b"graph_toml"].startswith(b"#:schema")
    assert table["sine.output"].to_pylist() == result["sine.output"].values.tolist()
    assert table["bits.bit"].to_pylist() == result["bits.bit"].values.tolist()
    slow = pyarrow.parquet.read_table(paths[1])
    assert slow.column_names == ["time", "adc.code", *(f"cells.sums[{i}]" for i in range(4))]
    assert slow["adc.code"].to_pylist() == result["adc.code"].values.tolist()
    assert slow["cells.sums[2]"].to_pylist() == result["cells.sums"].values[:, 2].tolist()


def test_a_summary_is_json_with_ticks_times_and_statistics(tmp_path: Path) -> None:
    result = mixed_result()
    data = json.loads(save_summary(result, tmp_path / "summary.json").read_text())
    assert (data["graph"], data["seed"], data["ticks"], data["interrupted"]) == ("a sine and bits", 7, 60, False)
    assert (data["seconds"], data["preparation_seconds"], data["graph_hash"]) == (0.25, 0.125, "0123abcd")
    assert data["signals"] == result.summary()


def test_a_summary_without_a_finite_mean_is_still_json(tmp_path: Path) -> None:
    result = made_result([made_trace("sine.output", [1.0, math.inf], "V")])
    text = save_summary(result, tmp_path / "summary.json").read_text()
    (signal,) = json.loads(text, parse_constant=pytest.fail)["signals"]
    assert (signal["min"], signal["max"], signal["mean"]) == (1.0, None, None)


@pytest.mark.parametrize("kind", ["nc", "csv", "parquet"])
@pytest.mark.parametrize("signal", ["sine.output", "bits.bit"])
def test_what_is_written_can_be_played_back_to_the_same_bits(kind: str, signal: str, tmp_path: Path) -> None:
    recorded = simulate(GRAPH, samples=200, engine="python")
    SAVERS[kind](recorded, tmp_path)
    unit = recorded[signal].unit
    played = Graph(
        name="played",
        rate="50 kHz",
        blocks={"motion": RecordedSignal(file=f"traces.{kind}", column=signal, unit=unit)},
        probes=["motion.output"],
        place=Place(folder=str(tmp_path)),
    )
    again = simulate(played, samples=200, engine="python")
    assert again["motion.output"].values.tolist() == recorded[signal].values.tolist()


@pytest.mark.exhaustive("csv", "nc")
@pytest.mark.parametrize("kind", ["nc", "csv", "parquet"])
def test_a_long_trace_is_written_in_pieces(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = 200_000
    np.save(tmp_path / "long.npy", np.arange(rows))
    values = np.load(tmp_path / "long.npy", mmap_mode="r")
    SAVERS[kind](mixed_result(), tmp_path)  # imports are not what is measured
    monkeypatch.setattr(result_module, "PIECE", 2048)
    tracemalloc.start()
    try:
        SAVERS[kind](made_result([made_trace("adc.code", values)]), tmp_path)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 1_000_000 < values.nbytes


@pytest.mark.parametrize("kind", SAVERS)
@pytest.mark.parametrize("size", [1000, 300_000])
def test_a_full_disk_is_an_oserror_and_leaves_the_file_that_was_there(kind: str, size: int, tmp_path: Path) -> None:
    long = {"note": "long\n" * 80_000}
    noise = np.random.default_rng(1).normal(size=60_000)
    (tmp_path / f"traces.{kind}").write_text("as it was")
    with largest_file(size), pytest.raises(OSError, match="File too large"):
        SAVERS[kind](made_result([made_trace("sine.output", noise)], provenance=long), tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [f"traces.{kind}"]
    assert (tmp_path / f"traces.{kind}").read_text() == "as it was"


@pytest.mark.parametrize("kind", SAVERS)
def test_a_folder_that_is_none_is_an_oserror(kind: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises((NotADirectoryError, FileExistsError)):
        SAVERS[kind](mixed_result(), tmp_path / "file")


def test_an_interruption_leaves_the_file_that_was_there(tmp_path: Path) -> None:
    path = tmp_path / "summary.json"
    path.write_text("as it was")

    def interrupted() -> None:
        with whole_file(path) as file:
            file.write(b"half")
            file.flush()
            assert len(list(tmp_path.iterdir())) == 2
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert [p.name for p in tmp_path.iterdir()] == ["summary.json"]
    assert path.read_text() == "as it was"


@pytest.mark.defect(
    "H899", before="cannot write or read .plot.svg.10628.part", after="names the file that was asked for"
)
def test_a_file_that_cannot_be_written_is_named_as_it_was_asked_for(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "folder").mkdir()
    for path in (tmp_path / "file" / "plot.svg", tmp_path / "folder"):
        with pytest.raises(OSError, match=r"\S") as caught:
            write_whole(path, "text")
        assert caught.value.filename == str(path)
        assert caught.value.filename2 is None
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "folder"]


@pytest.mark.parametrize("form", SAVERS)
@pytest.mark.defect("S957", before="cannot write or read a file: File too large", after="names the file")
def test_a_file_that_does_not_fit_is_named(form: str, tmp_path: Path) -> None:
    result = made_result([made_trace("a.out", np.arange(5000.0))])
    with largest_file(100), pytest.raises(OSError, match="too large") as caught:
        SAVERS[form](result, tmp_path)
    assert caught.value.filename == str(tmp_path / f"traces.{form}")


@pytest.mark.defect("S957", before="cannot write or read a file: File too large", after="names the file")
def test_texts_rows_and_checkpoints_that_do_not_fit_are_named(tmp_path: Path) -> None:
    graph = Graph(name="", rate="1 kHz", blocks={"a": Constant(value=1.0)}, probes=["a.output"], samples=1000)
    planned = plan(graph)
    rows = Recorder(planned.probes[0], 1000, tmp_path)
    trace = made_trace("a.output", np.arange(1000.0))
    stopped = dataclasses.replace(made_result([trace]), memory=start(planned))
    writers: dict[str, Callable[[], Any]] = {
        "a.txt": lambda: write_or_print("x" * 1000, tmp_path / "a.txt"),
        "a.output.npy": lambda: rows.keep(np.zeros(1000)),
        "proofmass-graph.json": lambda: write_schema_file(tmp_path / "proofmass-graph.json"),
        "b/a.output.npy": lambda: save_checkpoint(stopped, planned, tmp_path / "b"),
    }
    (tmp_path / "b").mkdir()
    for name, write in writers.items():
        with largest_file(500), pytest.raises(OSError, match=r"too large|requested and") as caught:
            write()
        assert caught.value.filename == str(tmp_path / name)
