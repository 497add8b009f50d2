"""Columns of recordings as series: CSV, Parquet, netCDF; uneven times are refused."""

from pathlib import Path

import h5netcdf
import numpy as np
import pyarrow
import pyarrow.parquet
import pytest

from proofmass import Graph, Series, read_series, simulate
from proofmass.blocks import Constant, Gain, RecordedSignal, Sine, VectorJoin, WhiteNoise
from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.design.identification.recordings import _table
from proofmass.runner.output.export import save_csv, save_netcdf, save_parquet
from proofmass.runner.plan.recording import RecordingError, read_columns


def test_what_a_run_wrote_is_read_back(tmp_path: Path) -> None:
    blocks = {"w": WhiteNoise(unit="V"), "o": Gain(input_unit="V", output_unit="V")}
    graph = Graph(name="", rate="3 kHz", blocks=blocks, wires=["w.output -> o.input"], probes=["o.output"], samples=100)
    result = simulate(graph)
    save_netcdf(result, tmp_path / "traces.nc")
    for path in [tmp_path / "traces.nc", *save_csv(result, tmp_path), *save_parquet(result, tmp_path)]:
        series = read_series(path, "o.output")
        assert series.values == pytest.approx(result["o.output"].values)
        assert series.rate == pytest.approx(3000.0, rel=1e-9)
        assert (series.name, series.unit) == ("o.output", "V")


def test_units_of_time_and_columns(tmp_path: Path) -> None:
    path = tmp_path / "table.parquet"
    table = {"time [ms]": np.arange(5) * 2.0, "a [V]": np.ones(5), "b [K]": np.arange(5.0)}
    pyarrow.parquet.write_table(pyarrow.table(table), path)
    assert read_series(path).name == "a"
    series = read_series(path, "b")
    assert (series.unit, series.period, list(series.values)) == ("K", pytest.approx(2e-3), [0.0, 1.0, 2.0, 3.0, 4.0])
    with pytest.raises(ModelError, match="there is no column 'c'"):
        read_series(path, "c")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time [s],a\n0,1\n1,1\n3,1\n4,1\n", r"row 2 is at 1 s|row 3 is at 3 s"),
        ("time [ms],a\n0,1\n1,1\n3,1\n4,1\n", r"row 2 is at 0.001 s|row 3 is at 0.003 s"),
        ("time [s],a\n0,1\n", "holds one row"),
        ("time [s],a\n2,1\n1,1\n0,1\n", "not equally spaced"),
        ("time [V],a\n0,1\n1,1\n", "its unit must be one of time"),
        ("time,a\n0,1\n1,x\n", "not a finite number"),
    ],
)
def test_what_is_no_series_is_refused(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "table.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ModelError, match=said):
        read_series(path)


@pytest.mark.defect(
    "C411", before="ValueError, or an rms of inf", after="refused: their squares are beyond all numbers"
)
@pytest.mark.parametrize("size", [1e300, 1e-300])
def test_values_beyond_squares_are_refused(size: float) -> None:
    values = size * np.random.default_rng(1).normal(size=100)
    with pytest.raises(ModelError, match=r"1e-140 to 1e\+140"):
        Series(values, 0.01)
    assert Series(np.full(10, 1e300), 0.01).duration == pytest.approx(0.1)


@pytest.mark.defect("S956", before="netCDF hid entries of vectors: another first column", after="those of CSV")
def test_entries_of_vectors_are_columns_of_every_form(tmp_path: Path) -> None:
    """A field whose second component is a sine: 3 V at a quarter of its turn, in row 5 of 20 a turn."""
    blocks = {
        "far": Constant(value=2.0, unit="V"),
        "sine": Sine(amplitude=3.0, frequency=50.0, unit="V"),
        "field": VectorJoin(size=2, unit="V"),
    }
    wires, probes = ["far.output -> field.first", "sine.output -> field.second"], ["field.output", "far.output"]
    graph = Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, probes=probes, samples=20)
    result = simulate(graph, engine="python")
    save_netcdf(result, tmp_path / "traces.nc")
    dataset = result.to_xarray()
    for path in [tmp_path / "traces.nc", *save_csv(result, tmp_path), *save_parquet(result, tmp_path)]:
        assert read_series(path).name == "field.output[0]"
        series = read_series(path, "field.output[1]")
        assert (series.name, series.unit, series.values[5]) == ("field.output[1]", "V", pytest.approx(3.0, rel=1e-15))
        for source in (path, dataset):
            found = _table(source, ["field.output[1]", "far.output"], "")
            assert found.column("field.output[1]").tolist() == series.values.tolist()
            assert found.column("far.output").tolist() == [2.0] * 20
            with pytest.raises(ModelError, match=r"has no column field\.output\[2\]"):
                _table(source, ["field.output[2]", "far.output"], "").column("field.output[2]")
        played = RecordedSignal(file=str(path), column="field.output[1]", unit="V")
        again = simulate(Graph(name="", rate="1 kHz", blocks={"p": played}, probes=["p.output"], samples=20))
        assert again["p.output"].values.tolist() == series.values.tolist()


def test_matrices_are_counted_row_by_row_and_pictures_are_no_columns(tmp_path: Path) -> None:
    with h5netcdf.File(tmp_path / "a.nc", "w") as data:
        data.dimensions.update({"time": 3, "row": 2, "column": 3, "pixel": 20_000})
        data.create_variable("time", ("time",), data=np.arange(3.0))
        data.create_variable("far", ("row", "time"), data=np.zeros((2, 3)))
        data.create_variable("matrix", ("time", "row", "column"), data=np.arange(18.0).reshape(3, 2, 3))
        data.create_variable("picture", ("time", "pixel"), data=np.zeros((3, 20_000)))
        data.create_variable("last", ("time",), data=np.zeros(3))
    seen = list[str]()
    with pytest.raises(RecordingError):
        read_columns(tmp_path / "a.nc", lambda names: seen.extend(names) or (0, names.index("none")))
    assert seen == ["time", *(f"matrix[{entry}]" for entry in range(6)), "last"]
    assert read_series(tmp_path / "a.nc", "matrix[4]").values.tolist() == [4.0, 10.0, 16.0]


@pytest.mark.defect("S958", before="traces.nc: column: there is no such file", after="the file alone")
@pytest.mark.parametrize(("text", "key"), [(None, ""), ("time,a\n0,1\n", "column"), ("time,b\n0,x\n", "")])
def test_a_column_is_named_where_it_is_wrong(tmp_path: Path, text: str | None, key: str) -> None:
    if text:
        (tmp_path / "a.csv").write_text(text)
    with pytest.raises(ModelError) as refused:
        read_series(tmp_path / "a.csv", "b")
    assert refused.value.problems[0].key == key
