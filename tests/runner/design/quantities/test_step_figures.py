"""Steps of continuous loops against the closed form of second order: w^2 / (s^2 + 2 d w s + w^2)."""

import math

import numpy as np
import pytest

from proofmass import Graph, margins
from proofmass.blocks import DiscreteIntegrator, LowPass, Negation
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.margins.margins import margins_of
from proofmass.runner.design.quantities.loop_figures import step_figures

WIRE = (("plant", "output", 0),)


def test_a_step_of_second_order() -> None:
    """L = w^2 / (s (s + 2 d w)) rises above the step by exp(-pi d / sqrt(1 - d^2))."""
    w, d = 40.0, 0.3
    matrix = np.array([[0.0, 1.0, 0.0, 0.0], [0.0, -2.0 * d * w, w * w, 0.0], [-1.0, 0.0, 0.0, 0.0]])
    states = (("plant", "place", -1), ("plant", "speed", -1))
    found = step_figures(
        margins_of(OpenLoop(PeriodMap(states, WIRE, WIRE, matrix, {}, 0.0), continuous=True), "main", "plant.output")
    )
    root = math.sqrt(1.0 - d * d)
    assert found["overshoot"] == pytest.approx(100.0 * math.exp(-math.pi * d / root), rel=1e-3)
    times = np.linspace(0.0, 1.0, 100_001)
    apart = np.exp(-d * w * times) * np.sin(w * root * times + math.acos(d)) / root
    assert found["settling_time"] == pytest.approx(times[np.flatnonzero(np.abs(apart) > 0.02)[-1]], rel=1e-2)


def test_a_step_that_is_there_at_once() -> None:
    """L = 99, at every instant."""
    loop = OpenLoop(PeriodMap((), WIRE, WIRE, np.array([[-99.0, 0.0]]), {}, 0.0), continuous=True)
    assert step_figures(margins_of(loop, "main", "plant.output")) == {"overshoot": 0.0, "settling_time": 0.0}


def test_a_step_of_first_order() -> None:
    """L = 3 / (s / 10 + 1) ends at 3 / 4, and comes within 2 % of that after log(50) / 40 s."""
    matrix = np.array([[-10.0, 10.0, 0.0], [-3.0, 0.0, 0.0]])
    loop = OpenLoop(PeriodMap((("plant", "x", -1),), WIRE, WIRE, matrix, {}, 0.0), continuous=True)
    found = step_figures(margins_of(loop, "main", "plant.output"))
    assert found["overshoot"] == 0.0
    assert found["settling_time"] == pytest.approx(math.log(50.0) / 40.0, rel=1e-3)


@pytest.mark.defect(
    "S970", before="no overshoot and no settling beyond 262,144 periods", after="figures at any time, as of a response"
)
def test_the_step_of_a_loop_that_is_slow_beside_its_ticks() -> None:
    """L = w^2 / (s (s + 2 d w)) in ticks of 1 us: it rises by exp(-pi d / sqrt(1 - d^2)) after 1.6 million ticks."""
    w, d = 2.0, 0.3
    graph = Graph(
        name="",
        rate="1 MHz",
        blocks={
            "minus": Negation(),
            "lag": LowPass(corner_frequency=d * w / math.pi),
            "control": DiscreteIntegrator(gain=0.5 * w / d, output_unit="1"),
        },
        wires=["control.output -> minus.input", "minus.output -> lag.input", "lag.output -> control.input"],
    )
    found = step_figures(margins(graph, "control.output"))
    root = math.sqrt(1.0 - d * d)
    assert found["overshoot"] == pytest.approx(100.0 * math.exp(-math.pi * d / root), rel=1e-4)
    times = np.linspace(0.0, 10.0, 100_001)
    apart = np.exp(-d * w * times) * np.sin(w * root * times + math.acos(d)) / root
    assert found["settling_time"] == pytest.approx(times[np.flatnonzero(np.abs(apart) > 0.02)[-1]], rel=1e-3)
