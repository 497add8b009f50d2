"""Columns of recordings as series: CSV, Parquet, netCDF; uneven times are refused."""

from pathlib import Path

import numpy as np
import pyarrow
import pyarrow.parquet
import pytest

from proofmass import Graph, Series, read_series, simulate
from proofmass.blocks import Gain, WhiteNoise
from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.output.export import save_csv, save_netcdf, save_parquet


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
