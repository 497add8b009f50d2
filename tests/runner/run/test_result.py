"""Traces, summaries, and the recorder that keeps rows in memory or on disk."""

import dataclasses
import re
import signal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from proofmass.blocks import WhiteNoise
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.graph import Probe
from proofmass.runner.planning.plan import PlannedProbe, plan
from proofmass.runner.run import result as result_module
from proofmass.runner.run import simulate as simulate_module
from proofmass.runner.run.checkpoint import save_checkpoint
from proofmass.runner.run.recorder import Recorder
from proofmass.runner.run.result import Result, Trace, statistics
from proofmass.runner.run.simulate import simulate
from proofmass.runner.run.sparkline import sparkline
from tests.by_hand.results import GRAPH, RATE, made_result, made_trace, mixed_result


def a_probe(dtype: type = int, shape: tuple[int, ...] = ()) -> PlannedProbe:
    return PlannedProbe("cells.sums", ("cells", "sums"), 10, dtype, shape, "V", "Sums.")


def test_a_trace_knows_its_times_and_label() -> None:
    trace = made_trace("adc.code", [1, 2, 3], "V", stride=10)
    assert trace.period == Fraction(1, 5000)
    assert trace.times.tolist() == [0.0, 10 * (1 / 50_000), 20 * (1 / 50_000)]
    assert trace.times_of(1, 3).tolist() == trace.times.tolist()[1:]
    assert trace.label == "adc.code [V]"


def test_a_result_is_a_mapping_of_traces_and_says_whether_it_was_interrupted() -> None:
    result = mixed_result()
    assert list(result) == ["sine.output", "bits.bit", "adc.code", "cells.sums"]
    assert result["adc.code"].values.shape == (6,)
    assert not result.interrupted
    assert dataclasses.replace(result, planned_ticks=61).interrupted


def test_probes_of_one_rate_share_an_axis_the_fastest_first() -> None:
    axes = mixed_result().axes()
    assert {name: [t.signal for t in traces] for name, traces in axes.items()} == {
        "time": ["sine.output", "bits.bit"],
        "time_2": ["adc.code", "cells.sums"],
    }


@pytest.mark.defect("S928", before="files gave rows of a clock offset the times of rows without", after="own axes")
def test_probes_of_another_clock_offset_have_an_axis_of_their_own() -> None:
    level = made_trace("a.level", [1.0, 2.0], stride=10)
    late = dataclasses.replace(made_trace("b.level", [3.0, 4.0], stride=10), phase=5)
    result = made_result([level, late])
    data = result.to_xarray()
    assert data["b.level"].dims == ("time_2",)
    assert data["time_2"].values.tolist() == [5 / 50_000, 15 / 50_000]
    assert data["time"].values.tolist() == [0.0, 10 / 50_000]
    table = result.to_pandas()
    assert table.index.tolist() == [0.0, 5 / 50_000, 10 / 50_000, 15 / 50_000], "in the order of time"
    assert table["b.level [1]"].dropna().tolist() == [3.0, 4.0]


@pytest.mark.defect("S931", before="2^53 + 1 of a slower probe was 2^53 in pandas: floats, for NaN", after="exact")
def test_large_integers_stay_whole_beside_faster_probes() -> None:
    codes = [2**53 + 1, -(2**53) - 1, 2**63 - 1]
    small = made_trace("small.code", [2**53, -(2**53)], stride=15)
    fast = made_trace("sine.output", np.zeros(30), "V")
    table = made_result([fast, made_trace("adc.code", codes, stride=10), small]).to_pandas()
    assert table["adc.code [1]"].dropna().tolist() == codes
    assert table["small.code [1]"].dropna().tolist() == [2.0**53, -(2.0**53)]
    assert table["small.code [1]"].dtype == np.float64


def test_xarray_has_units_axes_and_what_the_run_was_made_with() -> None:
    data = mixed_result().to_xarray()
    assert data["sine.output"].dims == ("time",)
    assert data["cells.sums"].dims == ("time_2", "cells.sums_entry")
    assert data["cells.sums"].attrs == {"units": "V/s", "long_name": "Sums, one per lag."}
    assert data["time_2"].attrs == {"units": "s", "long_name": "time"}
    assert data["time_2"].values.tolist() == pytest.approx([n / 5000 for n in range(6)])
    assert (data.attrs["seed"], data.attrs["base_rate"]) == ("7", "50000 Hz")
    assert data.attrs["graph_toml"].startswith("#:schema")


@pytest.mark.parametrize("piece", [1 << 20, 7, 1])
def test_statistics_do_not_depend_on_the_pieces(piece: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(result_module, "PIECE", piece)
    values = 1e9 + np.random.default_rng(1).normal(size=(101, 3))  # far from zero: a sum of squares would lose it
    found = statistics(values)
    np.testing.assert_allclose(found.mean, values.mean(axis=0), rtol=1e-15)
    np.testing.assert_allclose(found.std, values.std(axis=0, ddof=1), rtol=1e-6)
    assert found.lowest.tolist() == values.min(axis=0).tolist()
    assert found.highest.tolist() == values.max(axis=0).tolist()


def test_a_summary_of_every_kind_of_trace() -> None:
    result = mixed_result()
    rows = {row["signal"]: row for row in result.summary()}
    for name, row in rows.items():
        values = result[name].values
        assert row["rows"] == len(values)
        numbers = [row[key] for key in ("mean", "std", "min", "max")]
        assert numbers == pytest.approx(
            [values.mean(), values.std(ddof=1), float(values.min()), float(values.max())], rel=1e-12
        )
        assert row["last"] == values[-1].tolist()
    assert rows["cells.sums"]["entries"] == 4
    assert "entries" not in rows["adc.code"]


def test_a_summary_of_no_rows_has_no_numbers() -> None:
    result = made_result([made_trace("adc.code", np.zeros(0, dtype=int))])
    assert result.summary() == [{"signal": "adc.code", "unit": "1", "rows": 0}]
    assert ">0</td>" in result._repr_html_()


def test_the_table_of_a_notebook_is_escaped() -> None:
    table = made_result([made_trace("a<b", [1.0], "<V>")])._repr_html_()
    assert re.search(">a&lt;b</td><td[^>]*>&lt;V&gt;</td>", table)


@pytest.mark.parametrize(("dtype", "shape"), [(float, ()), (int, (3,)), (bool, ())])
@pytest.mark.parametrize("streamed", [False, True])
@pytest.mark.parametrize("kept", [20, 13, 0])
def test_a_recorder_keeps_rows_and_shortens_what_was_interrupted(
    dtype: type, shape: tuple[int, ...], streamed: bool, kept: int, tmp_path: Path
) -> None:
    rows: Any = np.arange(20 * int(np.prod(shape))).reshape(20, *shape).astype(dtype)[:kept]
    recorder = Recorder(a_probe(dtype, shape), 20, tmp_path if streamed else None)
    space = recorder.space(min(kept, 8))
    space[:] = rows[:8]
    recorder.keep(space)
    recorder.keep(rows[8:].copy())
    trace = recorder.finish(RATE)
    assert (trace.signal, trace.unit, trace.doc, trace.period) == ("cells.sums", "V", "Sums.", Fraction(1, 5000))
    assert trace.values.dtype == rows.dtype
    assert trace.values.shape == (kept, *shape)
    assert trace.values.tolist() == rows.tolist()
    assert isinstance(trace.values, np.memmap) == streamed
    if streamed:
        file = tmp_path / "cells.sums.npy"
        assert file.stat().st_size == 256 + rows.nbytes
        assert np.load(file).tolist() == rows.tolist()


def run_sine(samples: int, **options: Any) -> Result:
    graph = dataclasses.replace(GRAPH, probes=(Probe("sine.output"), Probe("bits.bit", 7)))
    return simulate(graph, samples=samples, engine="python", **options)


def test_a_run_too_large_for_memory_goes_to_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = run_sine(1000)
    monkeypatch.setattr(simulate_module, "IN_MEMORY", 0)
    streamed = run_sine(1000, folder=tmp_path)
    for name in whole:
        assert isinstance(streamed[name].values, np.memmap)
        assert streamed[name].values.tolist() == whole[name].values.tolist()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bits.bit.npy", "sine.output.npy"]


@pytest.mark.parametrize("folder", [False, True])
def test_an_interrupted_run_holds_the_rows_that_were_done(
    folder: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = run_sine(3000)
    if folder:
        monkeypatch.setattr(simulate_module, "IN_MEMORY", 0)

    def press(done: int, total: int) -> None:
        if 0 < done < total:
            signal.raise_signal(signal.SIGINT)

    part = run_sine(3000, progress=press, folder=tmp_path if folder else None)
    assert part.interrupted
    assert 0 < part.ticks < 3000
    for name in whole:
        rows = len(part[name].values)
        assert rows == -(-part.ticks // whole[name].stride)
        assert part[name].values.tolist() == whole[name].values[:rows].tolist()
        if folder:
            assert np.load(tmp_path / f"{name}.npy").shape == (rows,)


def test_statistics_of_numbers_whose_squares_overflow() -> None:
    found = statistics(np.array([1e247, -1e247, 3e247]))
    assert found.mean == pytest.approx(1e247, rel=1e-15)
    assert found.std == pytest.approx(2e247, rel=1e-15)
    assert (found.lowest, found.highest) == (-1e247, 3e247)
    assert statistics(np.array([0.0, 1e247, 2e247])).std == pytest.approx(1e247, rel=1e-15)
    assert statistics(np.array([1.7e308, 1.7e308])).mean == 1.7e308


def test_the_standard_deviation_of_a_trace_is_that_of_the_measure() -> None:
    graph = Graph(
        name="noise",
        rate="1 kHz",
        blocks={"noise": WhiteNoise(density=1.0)},
        probes=["noise.output"],
        measures={"spread": {"signal": "noise.output", "statistic": "std"}},
    )
    result = simulate(graph, samples=5, engine="python")
    (row,) = result.summary()
    assert row["std"] == pytest.approx(result.measures["spread"].value, rel=1e-14)
    assert row["std"] == pytest.approx(float(np.std(result["noise.output"].values, ddof=1)), rel=1e-14)


@pytest.mark.parametrize(("rate", "stride"), [(Fraction(200_000), 1), (Fraction(1000, 3), 7), (Fraction(10**15, 7), 3)])
def test_a_time_is_its_tick_over_the_rate_rounded_once(rate: Fraction, stride: int) -> None:
    trace = Trace("a.b", "V", "", stride, rate, np.zeros(1000))
    assert trace.times.tolist() == [float(row * stride / rate) for row in range(1000)]
    assert Trace("a.b", "V", "", 1, Fraction(200_000), np.zeros(2)).times[1] == 5e-6
    late = trace.times_of(10**15, 10**15 + 3).tolist()
    assert late == [float(row * stride / rate) for row in range(10**15, 10**15 + 3)]
    offset = Trace("a.b", "V", "", stride, rate, np.zeros(3), phase=5)
    for first in (0, 10**15):
        expected = [float((row * stride + 5) / rate) for row in range(first, first + 3)]
        assert offset.times_of(first, first + 3).tolist() == expected


def test_a_trace_is_an_array_with_a_line_to_read() -> None:
    trace = made_trace("adc.code", [3.0, -1.0, 2.0], "V")
    assert len(trace) == 3
    np.testing.assert_array_equal(np.asarray(trace) * 2.0, [6.0, -2.0, 4.0])
    assert np.asarray(trace, dtype=np.float32).dtype == np.float32
    assert repr(trace) == "<Trace of adc.code [V]: 3 rows every 2e-05 s, -1 to 3>"
    assert repr(made_trace("adc.code", [])) == "<Trace of adc.code [1]: no rows>"
    shown = trace._repr_html_()
    assert shown.startswith("<svg")
    assert "Trace of adc.code" in shown


def test_rows_of_a_trace_are_those_of_its_array() -> None:
    trace = simulate("library:template", duration="1 ms")["adc.code"]
    assert trace[-1] == trace.values[-1]
    assert [*trace[2:4]] == [*trace.values[2:4]]


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (lambda result: result.time, 'a trace has: result["sensor.displacement"].times'),
        (lambda result: result.data, 'a trace has: result["sensor.displacement"].values'),
        (lambda result: result.to_csv, 'as a table: result.to_pandas().to_csv("run.csv")'),
        (lambda result: result.tick, "did you mean ticks?"),
        (lambda result: result["adc.code"].time, "did you mean times?"),
        (lambda result: result["adc.code"].mean(), "its array has: trace.values.mean"),
    ],
)
@pytest.mark.friendly(8, "misspelt attributes of a result")
def test_an_attribute_that_is_not_there_is_answered_by_one_that_is(asked: Any, words: str) -> None:
    result = simulate("library:template", duration="1 ms")
    with pytest.raises(AttributeError) as wrong:
        asked(result)
    assert str(wrong.value).endswith(words)


def test_a_sparkline_keeps_spikes_and_is_empty_where_nothing_can_be_drawn() -> None:
    values = np.zeros(100_000)
    values[77_777] = 1.0
    points = [tuple(map(float, p.split(","))) for p in re.findall(r"[\d.]+,[\d.]+", sparkline(values))]
    assert len(points) == 240
    assert [x for x, y in points if y < 20.0] == [93.5]  # upwards is less
    assert (min(y for _, y in points), max(y for _, y in points)) == (2.0, 22.0)  # two pixels of 24 stay free
    assert sparkline(values + 7.0) == sparkline(values)
    assert sparkline(np.array([1.0])) == sparkline(np.array([1.0, np.nan])) == sparkline(np.zeros((3, 2))) == ""
    assert "12" in sparkline(np.ones(5))


def test_a_signal_that_was_not_recorded_names_the_nearest_one() -> None:
    with pytest.raises(KeyError) as caught:
        mixed_result()["adc.cod"]
    assert str(caught.value) == "'adc.cod' was not recorded; did you mean adc.code?"


@pytest.mark.defect("C822", before="AttributeError in the search for the nearest name", after="the trace of the probe")
def test_a_probe_of_the_graph_has_a_trace_and_a_number_has_none() -> None:
    found: Any = mixed_result()
    assert found[Probe("adc.code", every=7)] is found["adc.code"]
    with pytest.raises(KeyError, match="0 was not recorded"):
        found[0]


@pytest.mark.parametrize("signal", ["sine.output", "cells.sums"])
def test_mantissas_are_those_of_fixed_point_signals_alone(signal: str) -> None:
    with pytest.raises(ValueError, match=rf"{signal} is not a fixed-point signal of up to \d+ bits"):
        mixed_result()[signal].mantissas  # noqa: B018


def test_a_vector_is_a_table_with_a_column_for_each_entry() -> None:
    trace = mixed_result()["cells.sums"]
    frame = trace.to_pandas()
    assert list(frame.columns) == [f"cells.sums[{entry}] [V/s]" for entry in range(trace.values.shape[1])]
    assert frame.to_numpy().tolist() == trace.values.tolist()
    assert frame.index.tolist() == trace.times.tolist()
    single = mixed_result()["adc.code"].to_pandas()
    assert (single.name, single.tolist()) == ("adc.code [1]", mixed_result()["adc.code"].values.tolist())


def test_only_an_interrupted_run_has_a_checkpoint(tmp_path: Path) -> None:
    graph = Graph(name="short", rate="1 kHz", blocks={"noise": WhiteNoise(density=1.0)}, probes=["noise.output"])
    with pytest.raises(ValueError, match="the run was not interrupted"):
        save_checkpoint(simulate(graph, samples=3), plan(graph), tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.defect(
    "S1013", before="`trace == 3.0` was False, and counted no rows, where `!=` gave an array", after="rows"
)
def test_a_trace_is_compared_row_by_row() -> None:
    trace = made_trace("adc.code", [1, 3, 3])
    assert (trace == 3).tolist() == [False, True, True]
    assert (trace == dataclasses.replace(trace, shown_in="V")).all()
    assert np.count_nonzero(trace != 3) == 1


@pytest.mark.defect("S1014", before="`dataset['x'] *= 1000` scaled the trace: 3 V were 3000 V in it", after="refused")
def test_what_is_made_of_a_result_does_not_change_it() -> None:
    result = made_result([made_trace("a.level", [1.0, 3.0], "V")])
    result["a.level"].digest  # noqa: B018  # kept from now on
    data = result.to_xarray()
    with pytest.raises(ValueError, match="read-only"):
        data["a.level"] *= 1000.0
    with pytest.raises(ValueError, match="read-only"):
        result["a.level"].values[0] = 5.0
    copy = np.array(result["a.level"])
    copy *= 1000.0
    assert result["a.level"].values.tolist() == [1.0, 3.0]


@pytest.mark.defect("C890", before="`trace += 1` recursed without end", after="the values of a trace cannot be changed")
def test_a_trace_takes_no_results_of_functions() -> None:
    trace = made_trace("a.level", [1.0, 3.0])
    with pytest.raises(ValueError, match="the values of a trace cannot be changed"):
        trace += 1.0
    with pytest.raises(ValueError, match="the values of a trace cannot be changed"):
        np.add(trace, 1.0, out=trace)
    assert np.add(trace, 1.0, out=np.zeros(2)).tolist() == [2.0, 4.0]
