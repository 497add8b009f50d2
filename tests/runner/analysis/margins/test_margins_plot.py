"""Pictures of loops: what is drawn is what was computed, with names on all axes."""

import functools
import math
from itertools import pairwise

import control
import numpy as np
import pytest
import scipy.signal

from proofmass.blocks import DiscreteTransferFunction, Gain, Negation, Sum, UnitDelay
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.linearise import linearise
from proofmass.runner.analysis.linearisation.step import step_response
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.analysis.margins.plot import plot_margins, plot_sensitivities
from proofmass.runner.analysis.margins.sensitivity import Effect, Sensitivity
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.analysis.margins.step import closed_loop, shown_step
from tests.runner.analysis.linearisation.test_analog_loop import servo
from tests.runner.analysis.margins.test_margins import lifted


def slow_loop(gain: float) -> Graph:
    """An integrator of a part of its input each tick of 1 ms, with unity feedback."""
    return Graph(
        name="slow",
        rate="1 kHz",
        blocks={"error": Negation(), "gain": Gain(gain=gain), "sum": Sum(), "delay": UnitDelay()},
        wires=[
            "delay.output -> error.input",
            "error.output -> gain.input",
            "gain.output -> sum.first",
            "delay.output -> sum.second",
            "sum.output -> delay.input",
        ],
    )


GRAPH = read_graph(library_file("closed_loop_accelerometer.toml"))


@functools.cache
def of_accelerometer() -> Margins:
    return margins(GRAPH)


def test_the_step_response_is_that_of_the_closed_loop() -> None:
    step = step_response(closed_loop(of_accelerometer()))
    assert step is not None
    times, found = step.times, step.values
    closed = control.feedback(linearise(GRAPH, loop="main"), 1)
    _, expected = control.step_response(closed, times)
    assert len(found) > 1000
    assert found == pytest.approx(expected, rel=1e-8, abs=1e-9)


def test_the_step_of_an_analog_loop_is_drawn_until_it_has_settled() -> None:
    """L = 10 / (s (s + 1) (s + 10)), closed: 10 / (s^3 + 11 s^2 + 10 s + 10)."""
    (line, *_) = plot_margins(margins(servo(), "error.output")).axes[3].lines
    times, values = np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)
    parts, poles, _ = scipy.signal.residue([10.0], [1.0, 11.0, 10.0, 10.0, 0.0])
    expected = np.real(np.exp(np.outer(times, poles)) @ parts)
    assert len(times) > 100
    assert values == pytest.approx(expected, abs=1e-9)
    outside = times[np.abs(expected - 1.0) > 0.025]
    assert times[-1] == pytest.approx(1.6 * outside[-1], rel=0.05)


@pytest.mark.defect("S978", before="drawn for 262,144 ticks: 0.41 for 1 at the end", after="until it has settled")
@pytest.mark.parametrize("gain", [2e-4, 2e-6])
def test_a_step_that_settles_after_thousands_of_ticks_is_drawn_to_its_end(gain: float) -> None:
    """x[n + 1] = x[n] + g (1 - x[n]) comes within 2 % after log(50) / g ticks."""
    times, values = shown_step(margins(slow_loop(gain), "gain.output"))
    assert values[-1] == pytest.approx(1.0, abs=0.02)
    assert times[-1] == pytest.approx(1.6e-3 * math.log(50.0) / gain, rel=0.02)
    (line, *_) = plot_margins(margins(slow_loop(gain), "gain.output")).axes[3].lines
    drawn = np.asarray(line.get_ydata(), dtype=float)
    assert 1000 < len(drawn) < 5000
    assert (drawn.min(), drawn.max()) == (values.min(), values.max())


def test_an_unstable_step_is_drawn_for_six_of_its_time_constants() -> None:
    """x[n + 1] = x[n] - 2e-3 (1 - x[n]): the pole lies at 1.002."""
    times, values = shown_step(margins(slow_loop(-2e-3), "gain.output"))
    assert times[-1] == pytest.approx(6e-3 / math.log(1.002), rel=0.01)
    assert abs(values[-1]) == pytest.approx(math.exp(6.0) - 1.0, rel=0.01)


@pytest.mark.friendly(30, "Bode, Nyquist and step with names")
def test_four_panels_with_names() -> None:
    figure = plot_margins(of_accelerometer())
    names = {axes.get_ylabel(): axes.get_xlabel() for axes in figure.axes}
    assert names == {
        "|L| [dB]": "frequency [Hz]",
        "phase of L [deg]": "frequency [Hz]",
        "imaginary part of L": "real part of L",
        "step response of L / (1 + L)": "time [ms]",
    }
    magnitude = figure.axes[0].lines[0]
    w = 2.0 * np.pi * np.asarray(magnitude.get_xdata())
    expected = 20.0 * np.log10(np.abs(of_accelerometer().system.response(w)))
    assert np.asarray(magnitude.get_ydata()) == pytest.approx(expected)
    title = figure.get_suptitle()
    assert title == "main: gain margin 31.57 dB, phase margin 90.9°, delay margin 766.8 µs"


def test_a_gain_margin_at_the_end_of_the_axis_is_written_within_the_panel() -> None:
    """z - 1 + k has the pole -1 at k = 2, which is a limit at half the rate."""
    figure = plot_margins(margins(slow_loop(0.1), "gain.output"))
    figure.canvas.draw()
    panel = figure.axes[0]
    (text,) = (text for text in panel.texts if text.get_text())
    assert text.get_text() == f"{20.0 * math.log10(2.0 / 0.1):.1f} dB"
    left, right = text.get_window_extent().intervalx
    assert panel.bbox.x0 < left < right < panel.bbox.x1 + 1.0, "to a pixel"


@pytest.mark.defect("S857", before="a peak of -31 dB, that of the nearest point of the grid", after="-6 dB")
def test_the_peak_of_a_narrow_resonance_is_drawn() -> None:
    """k w^2 / (s^2 + 2 z w s + w^2) of 1 kHz rises to k / (2 z)."""
    k, z, w = 1e-3, 1e-3, 2000.0 * math.pi
    found = margins(servo(numerator=(k * w * w,), denominator=(1.0, 2.0 * z * w, w * w)), "error.output")
    drawn = np.asarray(plot_margins(found).axes[0].lines[0].get_ydata(), dtype=float)
    assert drawn.max() == pytest.approx(20.0 * math.log10(k / (2.0 * z)), abs=0.01)


def test_the_peak_of_a_narrow_resonance_of_a_sampled_loop_is_drawn() -> None:
    """k / (z - p)(z - p*) is largest next to p = r e^(j a), 1 - r from the circle."""
    k, r, a = 1e-9, 1.0 - 1e-6, 1.0
    mode = DiscreteTransferFunction(numerator=(0.0, 0.0, k), denominator=(1.0, -2.0 * r * math.cos(a), r * r))
    wires = ["mode.strictly_proper_part -> minus.input", "minus.output -> mode.input"]
    graph = Graph(name="mode", rate="1 kHz", blocks={"mode": mode, "minus": Negation()}, wires=wires)
    drawn = np.asarray(plot_margins(margins(graph, "minus.output")).axes[0].lines[0].get_ydata(), dtype=float)
    assert drawn.max() == pytest.approx(20.0 * math.log10(k / (1.0 - r) / (2.0 * math.sin(a))), abs=0.01)


@pytest.mark.parametrize("poles", [1, 2])
def test_a_phase_of_one_or_two_integrators_is_seen_between_both(poles: int) -> None:
    """It is -90 or -180 degrees at any frequency: its distance from -180 degrees is the margin."""
    found = margins(servo(numerator=(1.0,), denominator=(1.0, *[0.0] * poles)), "error.output")
    (panel,) = (axes for axes in plot_margins(found).axes if axes.get_ylabel() == "phase of L [deg]")
    low, high = panel.get_ylim()
    assert low < -180.0
    assert high > -90.0


def test_the_disk_of_a_nyquist_diagram_touches_the_curve_and_does_not_cut_it() -> None:
    (panel,) = (axes for axes in plot_margins(of_accelerometer()).axes if axes.get_ylabel() == "imaginary part of L")
    of = {str(line.get_label()).partition(" margin ")[0]: line.get_xydata() for line in panel.lines}
    disk, curve = (np.asarray(of[name]) @ [1.0, 1j] for name in ("disk", "negative frequencies"))
    middle, radius = 0.5 * (disk.real.min() + disk.real.max()), 0.5 * np.ptp(disk.real)
    assert np.abs(disk - middle) == pytest.approx(radius, rel=1e-3)
    assert any(np.array_equal(np.asarray(line.get_xydata()) @ [1.0, 1j], curve.conj()) for line in panel.lines)
    assert np.min(np.abs(curve - middle)) == pytest.approx(radius, rel=1e-3)
    assert -1.0 / disk.real.min() == pytest.approx(-disk.real.max(), rel=1e-2), "a gain and its inverse"


@pytest.mark.exhaustive
def test_margins_are_distances_also_of_a_loop_with_several_values_of_its_wire() -> None:
    found = margins(read_graph(library_file("force_balance_seismometer.toml")))
    assert found.gain_margin_frequency is None
    figure = plot_margins(found)
    texts = [[text.get_text() for text in panel.texts if text.get_text()] for panel in figure.axes]
    assert texts[0] == ["18.5 dB"]
    assert ["54.8°"] in texts
    below = figure.axes[0].get_ylim()[0]
    squares = next(line for line in figure.axes[0].lines if line.get_label() == "L < 0")
    assert np.asarray(squares.get_ydata()).min() > below, "the notch at 560 Hz goes below the picture"


def test_an_unstable_loop_is_drawn_and_says_so() -> None:
    figure = plot_margins(margins(lifted(1).with_parameters({"controller.numerator": [30.0, -25.0]})))
    assert figure.get_suptitle() == "main: unstable"
    left, _ = figure.axes[1].get_xlim()
    curve = figure.axes[1].lines[0].get_xydata()
    crossings = curve[:-1, 0][(curve[:-1, 1] * curve[1:, 1] < 0.0) & (curve[:-1, 0] < -1.0)]
    assert left < crossings.max() < -2.5, "the crossing that makes it unstable is in the picture"
    assert np.isfinite(np.asarray(figure.axes[3].lines[0].get_ydata())).all()


def test_a_tornado_has_a_bar_for_each_effect() -> None:
    effects = (Effect("a.gain", 2.0, "V", 3.0, 0.06), Effect("b.gain", 1.0, "V", -1.0, -0.01))
    zero = Effect("c.offset", 0.0, "V", 5.0, None)
    figure = plot_sensitivities([Sensitivity("scale factor", "V", 2.5, (*effects, zero))])
    (panel,) = figure.axes
    assert [patch.get_width() for patch in panel.patches] == pytest.approx([60.0, -10.0])  # type: ignore[attr-defined]
    assert [label.get_text() for label in panel.get_yticklabels()] == ["a.gain", "b.gain"]
    assert panel.get_xlabel() == "change for +1 % [mV]"


def test_rows_of_tornados_have_room_for_their_names() -> None:
    """Names do not run into each other, also in one of many rows above one of a single row."""
    effects = tuple(Effect(f"block_{number}.gain", 1.0, "V", 1.0, 0.01 * (number + 1)) for number in range(9))
    figure = plot_sensitivities([Sensitivity("many", "V", 1.0, effects), Sensitivity("one", "V", 1.0, effects[:1])])
    figure.canvas.draw()
    for panel in figure.axes:
        boxes = sorted((label.get_window_extent() for label in panel.get_yticklabels()), key=lambda box: box.y0)
        assert all(below.y1 < above.y0 for below, above in pairwise(boxes))
