"""The picture of a response: every axis and every line has its name, and numbers of axes do not touch."""

import math
from itertools import pairwise

import numpy as np
import pytest

from proofmass import Graph, response
from proofmass.blocks import Constant, Delay, LowPass
from proofmass.runner.analysis.response.plot import plot_response


@pytest.mark.friendly(29, "axes and bandwidths of responses are named")
def test_axes_and_the_bandwidth_are_named() -> None:
    found = response("library:template", "acceleration.output", "adc.number")
    gain, phase, step = plot_response(found).axes
    assert (gain.get_xlabel(), gain.get_ylabel()) == ("frequency [Hz]", "gain [1/(m/s²)]")
    assert (phase.get_xlabel(), phase.get_ylabel()) == ("frequency [Hz]", "phase [deg]")
    assert (step.get_xlabel(), step.get_ylabel()) == ("time [ms]", "output over step [1/(m/s²)]")
    (name,) = gain.texts
    assert name.get_text() == "−3 dB at 3.259 kHz"
    assert name.xy[0] == found.bandwidth


@pytest.mark.friendly(29, "numbers of axes are plain and do not touch")
def test_phases_are_eighths_of_a_turn_and_frequencies_plain_numbers() -> None:
    figure = plot_response(response("library:template", "acceleration.output", "adc.number"))
    figure.canvas.draw()
    gain, phase, _ = figure.axes
    assert list(phase.get_yticks()) == [-180.0, -135.0, -90.0, -45.0]
    shown = [label for label in gain.get_xticklabels(which="both") if label.get_text()]
    assert {"500", "1000", "2000", "5000"} <= {label.get_text() for label in shown}
    inside = [label for label in shown if gain.get_xlim()[0] <= label.get_position()[0] <= gain.get_xlim()[1]]
    boxes = sorted((label.get_window_extent() for label in inside), key=lambda box: box.x0)
    assert len(boxes) > 2
    assert all(left.x1 < right.x0 for left, right in pairwise(boxes))


@pytest.mark.defect("S965", before="41 numbers of phases on top of each other", after="eight, by multiples of a turn")
def test_phases_of_a_long_delay_do_not_touch() -> None:
    """A delay of 40 ticks turns by 40 halves of a turn up to half the rate."""
    blocks = {"u": Constant(value=0.0), "late": Delay(ticks=40)}
    graph = Graph(name="", rate="1 kHz", blocks=blocks, wires=["u.output -> late.input"])
    figure = plot_response(response(graph, "u.output", "late.output"))
    figure.canvas.draw()
    phase = figure.axes[1]
    boxes = sorted((label.get_window_extent() for label in phase.get_yticklabels()), key=lambda box: box.y0)
    assert all(step % 360.0 == 0.0 for step in phase.get_yticks())
    assert len(boxes) > 4
    assert all(below.y1 < above.y0 for below, above in pairwise(boxes))


@pytest.mark.defect("S979", before="drawn until it had decayed by 1e8: 4.7 times as long", after="until it has settled")
def test_a_step_without_overshoot_is_drawn_until_it_has_settled() -> None:
    """A low-pass of the time constant T comes within 2 % after log(50) T."""
    blocks = {"level": Constant(value=0.0), "filter": LowPass(corner_frequency=1.0)}
    graph = Graph(name="slow", rate="100 Hz", blocks=blocks, wires=["level.output -> filter.input"])
    _, _, panel = plot_response(response(graph, "level.output", "filter.output")).axes
    assert panel.get_xlabel() == "time [ms]"
    last = float(np.asarray(panel.lines[0].get_xdata(), dtype=float)[-1])
    assert last == pytest.approx(1.6e3 * math.log(50.0) / (2.0 * math.pi), abs=20.0)
