"""Plots: what is drawn, how axes are named, and that the same result gives the same bytes."""

import itertools
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import MassSpringDamper
from proofmass.blocks.declaration.shown_units import prefix, pretty
from proofmass.graphs.model.build import Graph
from proofmass.runner.output import plot
from proofmass.runner.output.plot import envelope, offset, plot_traces, save_plot
from proofmass.runner.run import result as result_module
from tests.by_hand.results import GRAPH, made_result, made_trace, mixed_result


def line_of(panel: Any) -> tuple[list[float], list[float]]:
    (line,) = panel.lines
    return list(line.get_xdata()), list(line.get_ydata())


@given(st.lists(st.integers(-5, 5), min_size=1, max_size=400), st.integers(1, 30), st.sampled_from([1, 13, 1 << 20]))
def test_no_extreme_of_any_stretch_is_lost(values: list[int], stretches: int, piece: int) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(result_module, "PIECE", piece)
        kept = envelope(np.array(values), stretches)
    assert all(a < b for a, b in itertools.pairwise(kept.tolist()))
    assert (kept[0], kept[-1]) == (0, len(values) - 1)
    assert len(kept) <= 2 * stretches + 2
    if len(values) <= 2 * stretches:
        assert len(kept) == len(values)
        return
    length = -(-len(values) // stretches)
    for start in range(0, len(values), length):
        stretch = values[start : start + length]
        drawn = [values[i] for i in kept.tolist() if start <= i < start + length]
        assert (min(drawn), max(drawn)) == (min(stretch), max(stretch))


def test_one_spike_in_ten_million_rows_is_drawn() -> None:
    values = np.zeros(10_000_000)
    values[6_543_210] = 1e-3
    panel = plot_traces(made_result([made_trace("sine.output", values, "V")])).axes[0]
    times, drawn = line_of(panel)
    assert len(drawn) <= 3002
    assert times[drawn.index(1.0)] == pytest.approx(6_543_210 / 50_000)
    assert panel.get_ylabel() == "sine.output [mV]"


@pytest.mark.parametrize(
    ("unit", "largest", "factor", "expected"),
    [
        ("V", 3e-5, 1e6, "µV"),
        ("V", 1.0, 1.0, "V"),
        ("V", 999.0, 1.0, "V"),
        ("V", 0.0, 1.0, "V"),
        ("mV", 1e-3, 1e3, "µV"),
        ("uV", 1.0, 1.0, "µV"),
        ("Hz", 5e4, 1e-3, "kHz"),
        ("m", 2e-9, 1e9, "nm"),
        ("kg", 1e-9, 1e9, "µg"),
        ("m/s^2", 1e-6, 1e6, "µm/s²"),
        ("N*m", 2e-6, 1e6, "µN·m"),
        ("rad", 4.7e-5, 1e6, "µrad"),
        ("g0", 1e-6, 1e6, "µg0"),
        ("ohm", 1e4, 1e-3, "kΩ"),
        ("s", 4e3, 1.0, "s"),
        ("s", 4e-3, 1e3, "ms"),
        ("nV/sqrt(Hz)", 2.0, 1.0, "nV/√Hz"),
        ("1", 5e9, 1.0, "1"),
        ("m^2", 1e-12, 1.0, "m²"),
        ("deg/s", 1e-3, 1.0, "°/s"),
        ("min", 1e-3, 1.0, "min"),
        ("1/s", 1e-3, 1.0, "1/s"),
        ("%", 1e-3, 1.0, "%"),
    ],
)
def test_units_get_the_prefix_that_suits(unit: str, largest: float, factor: float, expected: str) -> None:
    got, printed = prefix(unit, largest)
    assert got == pytest.approx(factor)
    assert printed == expected


@pytest.mark.parametrize(
    ("unit", "printed"),
    [
        ("(N*m)/(m/s^2)", "N·m/(m/s²)"),
        ("(V)/(rad)", "V/rad"),
        ("(1)*s/(1)", "s"),
        ("(1)/(1)", "1"),
        ("us", "µs"),
        ("1/10", "1/10"),
        ("m/s^2/sqrt(Hz)", "m/s²/√Hz"),
    ],
)
def test_units_are_printed_as_by_hand(unit: str, printed: str) -> None:
    assert pretty(unit) == printed


@pytest.mark.parametrize(
    ("lowest", "highest", "expected"),
    [
        (2.5, 2.50005, 2.5),
        (-1e6 - 1, -1e6 + 1, -1e6),
        (9.80661, 9.80669, 9.8066),
        (4.0, 6.0, 0.0),
        (0.0, 1e-9, 0.0),
        (2.5, 2.5, 0.0),
        (2.5, 2.5000000000000004, 0.0),
    ],
)
def test_a_signal_that_hardly_moves_is_drawn_about_a_round_number(
    lowest: float, highest: float, expected: float
) -> None:
    assert offset(lowest, highest) == expected


@pytest.mark.friendly(29, "axes of runs are named")
def test_axes_are_named_and_share_their_time() -> None:
    figure = plot_traces(mixed_result())
    sine, bits, code, sums = figure.axes
    assert [a.get_ylabel() for a in figure.axes] == ["sine.output [µV]", "bits.bit", "adc.code", "cells.sums [V/s]"]
    assert (code.get_xlabel(), sums.get_xlabel(), sine.get_xlabel()) == ("time [ms]", "lag", "")
    assert sine.get_shared_x_axes().joined(sine, code)
    assert not sine.get_shared_x_axes().joined(sine, sums)
    assert [label.get_text() for label in bits.get_yticklabels()] == ["false", "true"]
    assert figure.texts[0].get_text() == "a sine and bits"


def test_held_signals_are_steps_to_the_end_of_their_last_tick_and_others_lines() -> None:
    mass = Graph(name="mass", rate="50 kHz", blocks={"mass": MassSpringDamper()})
    bits: Any = plot_traces(made_result([made_trace("bits.bit", [True, False])])).axes[0].lines[0]
    assert bits.get_drawstyle() == "steps-post"
    assert list(bits.get_xdata()) == pytest.approx([0.0, 20.0, 40.0])  # µs
    assert list(bits.get_ydata()) == [1.0, 0.0, 0.0]
    moving: Any = plot_traces(made_result([made_trace("mass.displacement", [0.0, 1e-9], "m")], mass)).axes[0].lines[0]
    assert moving.get_drawstyle() == "default"
    assert list(moving.get_ydata()) == pytest.approx([0.0, 1.0])


def test_what_hardly_moves_says_what_was_taken_off() -> None:
    panel = plot_traces(made_result([made_trace("level.output", [2.5, 2.50005], "V")])).axes[0]
    assert panel.get_ylabel() == "level.output\n− 2.5 V [µV]"
    assert line_of(panel)[1][:2] == pytest.approx([0.0, 50.0])


def test_a_vector_shows_its_last_row_and_the_spread_of_the_rows_since_the_first_that_is_not_zero() -> None:
    rows = np.array([[0, 0, 0], [10, -4, 1], [14, -6, 1]])
    panel: Any = plot_traces(made_result([made_trace("cells.sums", rows, stride=1023)])).axes[0]
    last = next(line for line in panel.lines if line.get_label() == "last row")
    assert (list(last.get_xdata()), list(last.get_ydata())) == ([0, 1, 2], [14.0, -6.0, 1.0])
    (bars,) = panel.containers
    assert bars.get_label() == "mean ± std of 2 rows"
    assert list(bars.lines[0].get_ydata()) == [12.0, -5.0, 1.0]
    spread = [segment[:, 1].tolist() for segment in bars.lines[2][0].get_segments()]
    for ends, middle, std in zip(spread, (12.0, -5.0, 1.0), rows[1:].std(axis=0, ddof=1), strict=True):
        assert ends == pytest.approx([middle - std, middle + std])
    assert panel.get_xlabel() == "entry, counted from 0"


def test_no_rows_no_probes_many_probes_and_interruptions_are_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plot, "MOST_PANELS", 2)
    empty = plot_traces(made_result([made_trace("sine.output", np.zeros(0), "V")]))
    assert empty.axes[0].texts[0].get_text() == "no rows"
    assert plot_traces(made_result([])).texts[0].get_text() == "no probes"
    many = plot_traces(made_result([made_trace(f"b{i}.x", [1.0, 2.0]) for i in range(3)], planned_ticks=9))
    assert len(many.axes) == 2
    assert many.texts[0].get_text() == "a sine and bits (interrupted) (the first 2 of 3 probes)"


def test_a_long_name_goes_above_its_panel() -> None:
    name = "an_accelerometer_of_long_name.displacement"
    panel = plot_traces(made_result([made_trace(name, [1.0, 2.0], "m")])).axes[0]
    assert (panel.get_title(), panel.get_ylabel()) == (name, "[m]")


def test_dollars_in_a_name_are_no_formula(tmp_path: Path) -> None:
    graph = Graph(name="costs $x$ and $\\frac$", rate="1 Hz", blocks=GRAPH.blocks)
    path = save_plot(made_result([made_trace("sine.output", [1.0])], graph), tmp_path / "plot.svg")
    assert r"costs $x$ and $\frac$" in path.read_text()


@pytest.mark.exhaustive
@pytest.mark.parametrize(("kind", "head"), [("svg", b"<?xml"), ("png", b"\x89PNG"), ("pdf", b"%PDF")])
def test_the_same_result_gives_the_same_bytes(kind: str, head: bytes, tmp_path: Path) -> None:
    first = save_plot(mixed_result(), tmp_path / f"first.{kind}").read_bytes()
    again = save_plot(mixed_result(), tmp_path / f"again.{kind}").read_bytes()
    assert first == again
    assert first.startswith(head)
    assert not re.search(rb"\d{4}-\d\d-\d\dT|CreationDate", first)


def test_another_ending_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"cannot draw plot\.pgn: did you mean png\?"):
        save_plot(mixed_result(), tmp_path / "plot.pgn")
    assert not list(tmp_path.iterdir())


def test_the_settings_of_the_user_are_left_alone(tmp_path: Path) -> None:
    before = dict(matplotlib.rcParams)
    save_plot(mixed_result(), tmp_path / "plot.svg")
    assert dict(matplotlib.rcParams) == before


@pytest.mark.exhaustive
def test_pyplot_is_never_imported() -> None:
    code = (
        "import io, sys; from tests.by_hand.results import mixed_result;"
        "from proofmass.runner.output.plot import *; from proofmass.runner.output.pictures import *;"
        "write_figure(plot_traces(mixed_result()), io.BytesIO(), 'png'); assert 'matplotlib.pyplot' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=Path(__file__).parents[3])
