"""Sweeps against single runs: grids, values in step, integers and texts, named values, tables and refusals."""

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import proofmass
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.runner.output.sweeps import axis_of, plot_sweep, save_sweep_csv, sweep_lines
from proofmass.runner.run.simulate import simulate

GRAPH = read_graph_text("""\
name = "a converter"
rate = "1 kHz"
samples = 20
wires = ["ramp.output -> adc.voltage"]
probes = ["adc.code"]

[values]
slope = "10 V/s"

[measures]
last = { signal = "adc.number", statistic = "last" }
mean = { signal = "adc.number", statistic = "mean" }

[blocks]
ramp = { kind = "Ramp", slope = "= slope", unit = "V" }
adc = { kind = "AnalogToDigital", bits = 8, reference = "1 V" }
""")
ONE_NAME = """\
name = "one name"
rate = "1 kHz"
samples = 3
wires = ["source.output -> gain.input"]
values = { level = 1.0, factor = 2.0 }
measures = { level = { signal = "gain.output", statistic = "mean" } }
blocks.source = { kind = "Constant", value = "= level" }
blocks.gain = { kind = "Gain", gain = "= factor" }
"""


@pytest.fixture(scope="module")
def grid() -> proofmass.Sweep:
    return proofmass.sweep(GRAPH, {"adc.bits": [4, 8], "slope": ["5 V/s", "10 V/s", "20 V/s"]}, engine="python")


def test_each_point_is_a_run_of_its_own(grid: proofmass.Sweep) -> None:
    assert grid.shape == (2, 3)
    for i, bits in enumerate((4, 8)):
        for j, slope in enumerate(("5 V/s", "10 V/s", "20 V/s")):
            alone = simulate(GRAPH.with_parameters({"adc.bits": bits, "slope": slope}), engine="python")
            assert grid["last"][i, j] == alone.measures["last"].value
    assert len(set(grid["mean"].ravel().tolist())) > 3


def test_values_in_step_and_engines() -> None:
    values: dict[str, Any] = {"adc.bits": [4, 8, 12], "slope": [5.0, 10.0, 20.0]}
    zipped, compiled = (proofmass.sweep(GRAPH, values, zipped=True, engine=e) for e in ("python", "compiled"))
    assert zipped.shape == (3,)
    assert zipped["mean"].tolist() == compiled["mean"].tolist()
    assert list(zipped.points())[1] == {"adc.bits": 8, "slope": 10.0}
    assert [result.graph.blocks["adc"].bits for result in zipped.results] == [4, 8, 12]  # type: ignore[attr-defined]


def test_traces_are_kept_where_they_are_wanted(grid: proofmass.Sweep) -> None:
    assert not grid.results[0].traces
    short = proofmass.sweep(GRAPH, {"adc.bits": [4]}, traces=True, samples=5, engine="python")
    assert len(short.results[0]["adc.code"].values) == 5


def test_tables(grid: proofmass.Sweep, tmp_path: Any) -> None:
    assert grid.rows(["last"])[4] == {"adc.bits": 8, "slope": "10 V/s", "last": grid["last"][1, 1]}
    lines = sweep_lines(grid, ["last"])
    assert lines[0].split() == ["adc.bits", "slope", "last"]
    assert len(lines) == 7
    head, *rows = save_sweep_csv(grid, ["last", "mean"], tmp_path / "sweep.csv").read_text().splitlines()
    assert head == "adc.bits,slope,last [1],mean [1]"
    assert [float(row.split(",")[2]) for row in rows] == grid["last"].ravel().tolist()
    data = grid.to_xarray()
    assert data["mean"].dims == ("adc.bits", "slope")
    assert np.array_equal(data["mean"].values, grid["mean"])
    assert grid._repr_html_().count("<tr>") == 7


def test_curves(grid: proofmass.Sweep) -> None:
    panels = plot_sweep(grid, ["last", "mean"]).axes
    assert [len(panel.lines) for panel in panels] == [3, 3]
    assert panels[0].lines[1].get_ydata().tolist() == grid["last"][:, 1].tolist()  # type: ignore[union-attr]
    assert axis_of(["10 V/s", "20 mV/s"]) == ([10.0, 0.02], "V/s")


@pytest.mark.parametrize(
    ("values", "zipped", "message"),
    [
        ({}, False, "nothing is swept"),
        ({"adc.bits": []}, False, "has no values to sweep"),
        ({"adc.bits": "12"}, False, "has no values to sweep"),
        ({"adc.bits": [4, 8], "slope": [1.0]}, True, "values that move together must be equally many"),
        ({"adc.bits": range(1, 400), "slope": range(400)}, False, "too many points"),
        ({"adc.bits": [4, 99]}, False, "must be >= 2 and <= 32, at the point adc.bits = 99"),
        ({"adc.bist": [4]}, False, "has no such parameter, at the point adc.bist = 4"),
        ({"slpe": [4]}, False, "there is no such value, at the point slpe = 4"),
    ],
)
def test_what_is_refused(values: dict[str, Any], zipped: bool, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        proofmass.sweep(GRAPH, values, zipped=zipped)


@pytest.mark.defect("S900", before="the measure stood in the place of the swept value", after="both stand in the table")
@pytest.mark.parametrize("zipped", [False, True])
def test_a_value_and_a_measure_of_one_name(zipped: bool, tmp_path: Path) -> None:
    """The level is 3 times the value; as in studies, the parameter is the one that is called otherwise."""
    graph = read_graph_text(ONE_NAME)
    result = proofmass.sweep(graph, {"level": [1.0, 2.0], "factor": [3.0, 3.0][: 1 + zipped]}, zipped=zipped)
    assert [(row["parameter.level"], row["level"]) for row in result.rows()] == [(1.0, 3.0), (2.0, 6.0)]
    assert result.to_xarray()["parameter.level"].values.tolist() == [1.0, 2.0]
    assert sweep_lines(result, ["level"])[0].split() == ["parameter.level", "factor", "level"]
    with save_sweep_csv(result, ["level"], tmp_path / "sweep.csv").open(newline="") as file:
        assert list(csv.reader(file))[:2] == [["parameter.level", "factor", "level [1]"], ["1.0", "3.0", "3.0"]]


@pytest.mark.defect("S1016", before="values of a NumPy array were texts in a Dataset: '10' before '8'", after="numbers")
def test_values_of_an_array_are_numbers() -> None:
    result = proofmass.sweep(GRAPH, {"adc.bits": np.array([8, 10])})
    assert result.values["adc.bits"] == (8, 10)
    assert result.to_xarray()["adc.bits"].dtype.kind == "i"


@pytest.mark.defect("S1049", before="None, or what an array masks, ran with the number of the file", after="refused")
@pytest.mark.parametrize("values", [[8, None], np.ma.array([8, 10], mask=[False, True])])
def test_none_is_no_value_of_a_sweep(values: Any) -> None:
    with pytest.raises(ModelError, match=r"adc.bits: must be an integer, at the point adc.bits = None"):
        proofmass.sweep(GRAPH, {"adc.bits": values})


@pytest.mark.parametrize("name", ["adc.reference", "rate", "duration"])
def test_none_changes_no_parameter(name: str) -> None:
    with pytest.raises(ModelError, match=f"{name}: must be"):
        GRAPH.with_parameters({name: None})


@pytest.mark.defect("C897", before="TypeError: iteration over a 0-d array", after="has no values to sweep")
@pytest.mark.parametrize("values", [np.array(8), 8, "8"])
def test_a_number_alone_is_no_list(values: Any) -> None:
    with pytest.raises(ModelError, match="has no values to sweep"):
        proofmass.sweep(GRAPH, {"adc.bits": values})
