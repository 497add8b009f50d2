"""Pictures of loops: what is drawn is what was computed, with names on all axes."""

from itertools import pairwise

import control
import numpy as np
import pytest

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.analysis.linearisation.linearise import linearise
from proofmass.runner.analysis.margins.plot import plot_margins, plot_sensitivities, step_response
from proofmass.runner.analysis.margins.sensitivity import Effect, Sensitivity
from proofmass.runner.analysis.margins.stability import margins
from tests.runner.analysis.linearisation.test_analog_loop import servo

GRAPH = read_graph(library_file("closed_loop_accelerometer.toml"))


def test_the_step_response_is_that_of_the_closed_loop() -> None:
    found = step_response(margins(GRAPH))
    closed = control.feedback(linearise(GRAPH, loop="main"), 1)
    _, expected = control.step_response(closed, np.arange(len(found)) * 2e-5)
    assert len(found) > 1000
    assert found == pytest.approx(expected, rel=1e-8, abs=1e-9)


def test_the_step_response_of_an_analog_loop_goes_on_for_six_of_its_slowest_time_constants() -> None:
    """L = 10 / (s (s + 1) (s + 10)), closed: 10 / (s^3 + 11 s^2 + 10 s + 10)."""
    found = margins(servo(), "error.output")
    (line, *_) = plot_margins(found).axes[3].lines
    slowest = -float(np.max(np.roots([1.0, 11.0, 10.0, 10.0]).real))
    times, values = np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)
    assert times[-1] == pytest.approx(6.0 / slowest, rel=0.01)
    _, expected = control.step_response(control.tf([10.0], [1.0, 11.0, 10.0, 10.0]), times)
    assert len(times) > 100
    assert values == pytest.approx(expected, abs=1e-9)


@pytest.mark.friendly(30, "Bode, Nyquist and step with names")
def test_four_panels_with_names() -> None:
    figure = plot_margins(margins(GRAPH))
    names = {axes.get_ylabel(): axes.get_xlabel() for axes in figure.axes}
    assert names == {
        "|L| [dB]": "frequency [Hz]",
        "phase of L [deg]": "frequency [Hz]",
        "imaginary part of L": "real part of L",
        "step response of L / (1 + L)": "time [ms]",
    }
    magnitude = figure.axes[0].lines[0]
    w = 2.0 * np.pi * np.asarray(magnitude.get_xdata())
    expected = 20.0 * np.log10(np.abs(margins(GRAPH).system.response(w)))
    assert np.asarray(magnitude.get_ydata()) == pytest.approx(expected)
    title = figure.get_suptitle()
    assert title == "main: gain margin 31.57 dB, phase margin 90.9°, delay margin 766.8 µs"


@pytest.mark.exhaustive
def test_margins_are_distances_also_of_a_loop_with_several_values_of_its_wire() -> None:
    found = margins(read_graph(library_file("force_balance_seismometer.toml")))
    assert found.gain_margin_frequency is None
    figure = plot_margins(found)
    texts = [[text.get_text() for text in panel.texts if text.get_text()] for panel in figure.axes]
    assert texts[0] == ["21.3 dB"]
    assert ["58.6°"] in texts
    below = figure.axes[0].get_ylim()[0]
    squares = next(line for line in figure.axes[0].lines if line.get_label() == "L < 0")
    assert np.asarray(squares.get_ydata()).min() > below, "the notch at 600 Hz goes below the picture"


def test_an_unstable_loop_is_drawn_and_says_so() -> None:
    figure = plot_margins(margins(GRAPH.with_parameters({"pickoff.gain": 8e5})))
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
