"""Readings from tables and from runs: the right columns, or an answer that says what is wrong and where."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from proofmass.blocks import Gain, Ramp
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.design.fit.data import Readings, read_table, run_cycle
from proofmass.runner.output.export import save_csv, save_netcdf, save_parquet
from proofmass.runner.run.simulate import simulate
from tests.by_hand.temperature_sets import DEVICES, TEMPERATURE

GRAPH = library_file("temperature_compensation_m1.toml")
SIGNALS = ("thermometer.voltage", "noisy.output")
ROWS = "".join(f"{t},{1.0 + t * t}\n" for t in (0.6, 0.9, 1.1, 1.4, 1.8))


def table(folder: Path, text: str, name: str = "data.csv") -> Path:
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


@pytest.mark.parametrize("name", DEVICES)
def test_the_sets_of_the_library_are_those_of_the_formula(name: str) -> None:
    readings = read_table(library_file(f"zero_bias_{name}.csv"))
    assert (readings.temperature == TEMPERATURE).all()
    assert readings.output == pytest.approx(DEVICES[name].output(), rel=1e-14)
    assert (readings.temperature_name, readings.temperature_unit) == ("sensor", "V")
    assert (readings.output_name, readings.output_unit) == ("zero bias", "V")


@pytest.mark.parametrize(
    ("head", "row", "names"),
    [
        ("temperature,bias", "{t},{v}", {}),
        ("time,temperature,bias", "0,{t},{v}", {}),
        ("bias,temperature", "{v},{t}", {"temperature": "temperature"}),
        ("bias,temperature", "{v},{t}", {"output": "bias"}),
        ("a,b,c,d", "9,{v},9,{t}", {"temperature": "d", "output": "b"}),
        ("a,T,bias", "9,{t},{v}", {"temperature": "T", "output": "bias"}),
    ],
)
def test_which_columns(tmp_path: Path, head: str, row: str, names: dict[str, str]) -> None:
    rows = [row.format(t=t, v=t * t) for t in (1.0, 2.0, 3.0, 4.0, 5.0)]
    readings = read_table(table(tmp_path, "\n".join([head, *rows])), **names)
    assert readings.temperature.tolist() == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert readings.output.tolist() == [1.0, 4.0, 9.0, 16.0, 25.0]


@pytest.mark.parametrize(
    ("text", "names", "told"),
    [
        ("T,bias\n" + ROWS.replace("1.1,", "1.1,nan"), {}, ["data.csv:4", "not a finite number"]),
        ("T,bias\n" + ROWS.replace("1.1,", "1.1,inf"), {}, ["data.csv:4", "not a finite number"]),
        ("T,bias\n" + ROWS + "1.9\n", {}, ["data.csv:7", "has 1 cells"]),
        (ROWS, {}, ["data.csv:1", "needs a row of column names"]),
        ("T;bias\n" + ROWS.replace(",", ";"), {}, ["separate the columns by commas"]),
        ("T,bias\n", {}, ["holds no rows"]),
        ("T,bias\n" + ROWS, {"temperature": "temp"}, ["there is no column 'temp'"]),
        ("sensor,bias\n" + ROWS, {"output": "bais"}, ["there is no column 'bais'", "did you mean bias?"]),
        ("T,bias\n" + ROWS, {"temperature": "T", "output": "T"}, ["cannot be both"]),
        ("a,b,c\n1,2,3\n", {}, ["which two", "--temperature and --output", "a, b, c"]),
        ("bias,temperature\n" + ROWS, {}, ["look swapped", "--temperature 'temperature' --output 'bias'"]),
        ("T,bias\n1,2\n1,3\n2,4\n2,5\n3,6\n4,7\n", {}, ["too few different temperatures", "4 in 6 rows"]),
        ("T,bias\n" + "".join(f"{t},2.5\n" for t in range(9)), {}, ["the same in every row", "2.5"]),
        ("T,bias\n" + "".join(f"{t},{t}e300\n" for t in range(9)), {}, ["at most 1e+15"]),
        ("T,bias\n" + "".join(f"1000000000.{t},{t}\n" for t in range(9)), {}, ["T: hardly moves"]),
    ],
)
def test_bad_tables(tmp_path: Path, text: str, names: dict[str, str], told: list[str]) -> None:
    path = table(tmp_path, text)
    with pytest.raises(ModelError) as caught:
        read_table(path, **names)
    for words in told:
        assert words in str(caught.value)
    assert "data.csv" in str(caught.value)


@pytest.mark.exhaustive
def test_a_run_and_its_files_hold_the_same_readings(tmp_path: Path) -> None:
    graph = read_graph(GRAPH)
    run = run_cycle(graph, *SIGNALS, engine="python")
    result = simulate(graph, engine="python")
    files = [
        *save_csv(result, tmp_path),
        *save_parquet(result, tmp_path),
        save_netcdf(result, tmp_path / "traces.nc"),
    ]
    assert {file.suffix for file in files} == {".csv", ".parquet", ".nc"}
    for file in files:
        read = read_table(file, *SIGNALS)
        assert (read.temperature == run.temperature).all()
        assert (read.output == run.output).all()
        assert (read.temperature_unit, read.output_unit) == ("V", "V")
    with pytest.raises(ModelError, match=r"did you mean noisy\.output"):
        read_table(tmp_path / "traces.nc", "thermometer.voltage", "noisy.outptu")


@pytest.mark.exhaustive
def test_netcdf_on_two_time_axes_is_refused(tmp_path: Path) -> None:
    text = GRAPH.read_text(encoding="utf-8").replace('"noisy.output",', '{ signal = "noisy.output", every = 2 },')
    path = table(tmp_path, text, "graph.toml")
    save_netcdf(simulate(read_graph(path), engine="python"), tmp_path / "traces.nc")
    with pytest.raises(ModelError, match="not on one time axis"):
        read_table(tmp_path / "traces.nc", *SIGNALS)


def test_signals_of_a_graph_that_do_not_go_together(tmp_path: Path) -> None:
    text = GRAPH.read_text(encoding="utf-8").replace('kind = "Difference"', 'kind = "Difference"\nrate = "120 s"')
    graph = read_graph(table(tmp_path, text, "graph.toml"))
    with pytest.raises(ModelError, match="another rate"):
        run_cycle(graph, "thermometer.voltage", "compensated.output")
    with pytest.raises(ModelError, match="did you mean voltage"):
        run_cycle(graph, "thermometer.volts", "noisy.output")
    test_graph = read_graph(library_file("pn_self_test_minimal.toml"))
    vector = next(p.signal for p in test_graph.probes if "impulse_response" in p.signal)
    with pytest.raises(ModelError, match="not a signal of single numbers"):
        run_cycle(test_graph, vector, vector, samples=5000)


@pytest.mark.defect("S934", before="a slope of 0.6 K for 0, or an error inside", after="another clock offset")
@pytest.mark.parametrize("ticks", [9, 10])  # at ten both have as many rows
def test_signals_at_other_times_do_not_go_together(ticks: int) -> None:
    graph = Graph(
        name="at other times",
        rate="10 Hz",
        blocks={"heat": Ramp(), "early": Gain(), "late": Gain()},
        wires=["heat.output -> early.input", "heat.output -> late.input"],
        rates={"early": "2 Hz", "late": "2 Hz"},
        offsets={"late": "0.3 s"},
    )
    with pytest.raises(ModelError, match=r"late\.output: has another clock offset than the temperature"):
        run_cycle(graph, "early.output", "late.output", samples=ticks)


def test_a_constant_is_taken_off() -> None:
    readings = Readings("made", TEMPERATURE, TEMPERATURE**2 + 2.5, "T", "V")
    assert readings.less(2.5).output == pytest.approx(TEMPERATURE**2, abs=1e-15)


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e16])
def test_numbers_beyond_all_bounds(bad: float) -> None:
    output: Any = TEMPERATURE.copy()
    output[7] = bad
    with pytest.raises(ModelError, match="must be finite"):
        Readings("made", TEMPERATURE, output, "T", "V")
