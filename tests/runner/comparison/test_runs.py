"""Two runs compared: what differs, from when on, by how much, and within which tolerance."""

import json
from pathlib import Path

import h5netcdf
import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.runner.comparison.runs import Allowance, TraceChange, _trace, compare_runs
from proofmass.runner.comparison.tables import run_tables, text_of
from proofmass.runner.output.export import save_netcdf, save_summary
from proofmass.runner.run.simulate import simulate
from tests.by_hand.design_texts import INTEGRATING

TEXT = """\
name = "a ramp that is sampled"
rate = "1 kHz"
samples = 200
wires = ["ramp.output -> gain.input", "gain.output -> adc.voltage"]
probes = ["gain.output", { signal = "adc.number", every = 4 }]

[measures]
last = { signal = "gain.output", statistic = "last" }
mean = { signal = "adc.number", statistic = "mean" }

[blocks]
ramp = { kind = "Ramp", slope = "1 V/s", unit = "V" }
gain = { kind = "Gain", gain = 2, input_unit = "V", output_unit = "V" }
adc = { kind = "AnalogToDigital", bits = 8, reference = "5 V" }
"""


def saved(folder: Path, text: str = TEXT) -> Path:
    result = simulate(read_graph_text(text), engine="python")
    folder.mkdir()
    save_netcdf(result, folder / "traces.nc")
    save_summary(result, folder / "summary.json")
    return folder


@pytest.fixture(scope="module")
def before(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return saved(tmp_path_factory.mktemp("runs") / "before")


def test_equal_runs(before: Path, tmp_path: Path) -> None:
    same = compare_runs(before, saved(tmp_path / "after", TEXT.replace("2,", "2.0,")), Allowance())
    assert same.same
    assert not same.graph
    assert not same.facts
    assert {trace.signal: (trace.rows, trace.largest) for trace in same.traces} == {
        "gain.output": (200, 0.0),
        "adc.number": (50, 0.0),
    }


@pytest.mark.friendly(36, "a gain that differs between runs")
def test_a_gain_that_differs(before: Path, tmp_path: Path) -> None:
    """2 and 2.02 times a ramp of 1 V/s: 20 mV/s apart, the most after 199 ms; allowed is a part of 398 mV."""
    after = saved(tmp_path / "after", TEXT.replace("gain = 2", "gain = 2.02"))
    found = compare_runs(before, after, Allowance())
    assert [difference.key for difference in found.graph] == ["blocks.gain.gain"]
    by_name = {trace.signal: trace for trace in found.traces}
    trace, times = by_name["gain.output"], np.arange(200) / 1000
    assert trace.largest == pytest.approx(0.02 * 0.199, rel=1e-12)
    assert trace.rms == pytest.approx(np.sqrt(np.mean((0.02 * times) ** 2)), rel=1e-12)
    assert trace.first == 0.001
    assert not found.same
    partly = {t.signal: t for t in compare_runs(before, after, Allowance(absolute=1.01e-3)).traces}
    assert partly["gain.output"].first == 0.051
    assert {t.signal: t.same for t in compare_runs(before, after, Allowance(relative=0.0101)).traces}["gain.output"]
    last = next(measure for measure in found.measures if measure.name == "last")
    assert (last.before, last.after, last.same) == (pytest.approx(0.398), pytest.approx(0.40198), False)
    assert json.dumps(found.as_data())


@pytest.mark.exhaustive
def test_what_cannot_be_compared(before: Path, tmp_path: Path) -> None:
    texts = {
        "rows": TEXT.replace("samples = 200", "samples = 201"),
        "signals": TEXT.replace('"gain.output", {', '"ramp.output", {'),
        "units": TEXT.replace('output_unit = "V"', 'output_unit = "A"').replace(
            '"gain.output -> adc', '"ramp.output -> adc'
        ),
        "times": TEXT.replace("1 kHz", "2 kHz"),
    }
    problems = {
        name: {t.signal: t.problem for t in compare_runs(before, saved(tmp_path / name, text), Allowance()).traces}
        for name, text in texts.items()
    }
    assert problems["rows"] == {"gain.output": "200 rows before, 201 after", "adc.number": "50 rows before, 51 after"}
    assert problems["signals"]["gain.output"] == "not recorded after"
    assert problems["signals"]["ramp.output"] == "not recorded before"
    assert problems["units"]["gain.output"] == "now in A"
    assert problems["times"]["gain.output"] == "at other times"


def traced(folder: Path, name: str, times: list[float], values: list[float], unit: str = "V") -> Path:
    """A file with one trace."""
    with h5netcdf.File(folder / f"{name}.nc", "w") as data:
        data.dimensions["time"] = len(times)
        data.create_variable("time", ("time",), np.float64)[:] = times
        signal = data.create_variable("signal", ("time",), np.float64)
        signal[:] = values
        signal.attrs["units"] = unit
    return folder / f"{name}.nc"


@pytest.mark.parametrize(
    ("times", "unit", "problem"),
    [
        ([0.0, 0.1, 0.2], "A", "now in A"),
        ([0.0, 0.1], "V", "3 rows before, 2 after"),
        ([0.0, 0.15, 0.2], "V", "at other times"),
        ([0.0, 0.1, 0.3], "V", "at other times"),
    ],
)
def test_traces_that_cannot_be_compared(times: list[float], unit: str, problem: str, tmp_path: Path) -> None:
    """Another unit, other rows, another step, another end: the unit is the one before."""
    before = traced(tmp_path, "before", [0.0, 0.1, 0.2], [1.0, 2.0, 3.0])
    after = traced(tmp_path, "after", times, [1.0, 2.0, 3.0][: len(times)], unit)
    with h5netcdf.File(before, "r") as first, h5netcdf.File(after, "r") as second:
        nothing = TraceChange("signal", "V", 0, 0.0, 0.0, 0.0, None, problem)
        assert _trace("signal", first, second, Allowance()) == nothing


@pytest.mark.parametrize(("rows", "apart"), [(0, 0.0), (1, 0.0), (2, 0.5), (3, 1.0)])
def test_traces_of_few_rows(rows: int, apart: float, tmp_path: Path) -> None:
    """Row n is n / 2 apart, so the first that differs is the second."""
    values = [1.0, 2.0, 4.0][:rows]
    moved = [value + 0.5 * number for number, value in enumerate(values)]
    files = [traced(tmp_path, str(n), [0.0, 0.1, 0.2][:rows], of) for n, of in enumerate((values, moved))]
    with h5netcdf.File(files[0], "r") as first, h5netcdf.File(files[1], "r") as second:
        found = _trace("signal", first, second, Allowance())
        within = _trace("signal", first, second, Allowance(relative=0.2))
    rms = np.sqrt(sum((0.5 * n) ** 2 for n in range(rows)) / max(rows, 1))
    assert found == TraceChange("signal", "V", rows, apart, pytest.approx(rms), 0.0, 0.1 if apart else None)
    assert (within.size, within.same) == (max(values, default=0.0), apart <= 0.2 * within.size)


def test_folders_that_hold_something_else(before: Path, tmp_path: Path) -> None:
    after = saved(tmp_path / "after")
    (after / "traces.nc").unlink()
    with pytest.raises(ModelError, match=r"has no traces\.nc"):
        compare_runs(before, after, Allowance())
    (after / "summary.json").write_text("no summary")
    with pytest.raises(ModelError, match=r"summary\.json cannot be read"):
        compare_runs(before, after, Allowance())


@pytest.mark.exhaustive
def test_margins_of_loops_that_differ(tmp_path: Path) -> None:
    """K T = 2 sin(w T / 2) at the crossover w, and a phase margin of 90 deg - 1.5 w T: 100 and 110 1/s."""
    short = INTEGRATING.replace('"0.5 s"', '"20 ms"')
    texts = [short, short.replace("gain = 100.0", "gain = 110.0"), short.replace("gain = 100.0", "gain = 5000.0")]
    first, second, wild = (saved(tmp_path / str(number), text) for number, text in enumerate(texts))
    margins = {margin.name: margin for margin in compare_runs(first, second, Allowance(relative=0.2)).margins}
    phases = [90.0 - 3.0 * np.degrees(np.arcsin(gain * 1e-3 / 2.0)) for gain in (100.0, 110.0)]
    phase = margins["main.phase_margin"]
    assert (phase.before, phase.after) == pytest.approx(tuple(phases), rel=1e-9)
    assert phase.same
    assert not compare_runs(first, second, Allowance(relative=1e-3)).same
    lost = {margin.name: margin for margin in compare_runs(first, wild, Allowance(relative=9.0)).margins}
    assert lost["main.phase_margin"].after is None
    assert not lost["main.phase_margin"].same
    assert lost["main.stable"].after == 0.0
    assert not compare_runs(first, first, Allowance()).margins, "equal graphs have equal margins"
    text = "\n".join(text_of(run_tables(compare_runs(first, second, Allowance()))))
    assert "main.phase_margin" in text


@pytest.mark.defect(
    "S1017", before="traces that an earlier run had left were compared as those of the last", after="refused"
)
def test_traces_of_an_earlier_run_are_not_those_of_the_last(before: Path, tmp_path: Path) -> None:
    again = saved(tmp_path / "again", TEXT.replace("gain = 2", "gain = 2.02"))
    save_summary(simulate(read_graph_text(TEXT), engine="python"), again / "summary.json")  # as `--format csv` does
    with pytest.raises(ModelError, match=r"traces\.nc is not of the run of summary\.json"):
        compare_runs(before, again, Allowance())
