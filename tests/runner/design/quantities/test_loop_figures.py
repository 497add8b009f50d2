"""Slopes of figures against closed forms: exact where there is one, else by differences of exact matrices."""

import math

import numpy as np
import pytest

from proofmass import response
from proofmass.blocks import AnalogToDigital, Constant, Product, Sine
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.quantities import FIGURES, LoopFigure, ResponseFigure
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.margins.margins import margins_of
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.design.quantities.evaluator import Evaluator
from proofmass.runner.design.quantities.loop_figures import differences, read_figure, value_of_figure
from proofmass.runner.planning.plan import plan
from tests.runner.analysis.margins.test_lines_of_a_period import PROPORTIONAL, RATE, tracking

WIRE = (("plant", "output", 0),)


def test_slopes_of_a_step_are_those_of_its_closed_form() -> None:
    """K / (s / 10 + 1) settles after log(50) / (10 + 10 K) s, and never rises above its end."""
    matrix, by_gain = np.array([[-10.0, 10.0, 0.0], [-3.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    moved = PeriodMap((("plant", "x", -1),), WIRE, WIRE, matrix, {"gain": by_gain}, 0.0)
    loop = OpenLoop(moved, continuous=True)
    limits = margins_of(loop, "main", "plant.output")
    found = read_figure(limits, loop, "settling_time", {"gain": 3.0, "other": 1.0})
    assert found.slopes == {"gain": pytest.approx(-10.0 * math.log(50.0) / 40.0**2, rel=1e-3)}
    assert read_figure(limits, loop, "overshoot", {"gain": 3.0}).slopes == {"gain": 0.0}


def test_differences_suit_the_size_of_each_parameter() -> None:
    """Of 1 / p, and of what has no number on one side."""
    sizes = {"tiny": -1e-9, "usual": 2.0, "large": 1e12}
    found = differences(lambda name, step: 1.0 / (sizes[name] + step), sizes)
    assert found == {name: pytest.approx(-1.0 / size**2, rel=1e-6) for name, size in sizes.items()}
    assert differences(lambda _, step: math.exp(step) if step < 0.0 else math.inf, {"edge": 0.0}) == {"edge": 0.0}
    assert differences(lambda _, step: math.exp(step), {"nothing": 0.0}) == {"nothing": pytest.approx(1.0)}


def test_a_delay_margin_of_one_sample_does_not_move() -> None:
    """z^2 + 0.8 z + k stays stable, and z^3 + 0.8 z^2 + k unstable, for all k near 0.3."""
    matrix, by_gain = np.zeros((3, 4)), np.zeros((3, 4))
    matrix[0, 0], matrix[0, 2], matrix[1, 0], matrix[2, 1], by_gain[1, 0] = -0.8, -1.0, 0.3, 1.0, 1.0
    states = (("filter", "x", -1), ("register", "x", -1))
    loop = OpenLoop(PeriodMap(states, WIRE, WIRE, matrix, {"gain": by_gain}, 1e-3))
    found = read_figure(margins_of(loop, "main", "plant.output"), loop, "delay_margin", {"gain": 0.3})
    assert found.value == pytest.approx(1e-3)
    assert found.slopes == {"gain": 0.0}


def lags(gain: float, order: int, *, aside: int = 0) -> OpenLoop:
    """K / (s / 10 + 1)^n, and an integral of the first lag beside the loop."""
    size = order + aside
    matrix, by_gain = np.zeros((size + 1, size + 2)), np.zeros((size + 1, size + 2))
    for row in range(order):
        matrix[row, row], matrix[row, row - 1 if row else size] = -10.0, 10.0
    matrix[order:size, 0] = 1.0
    matrix[size, order - 1], by_gain[size, order - 1] = -gain, -1.0
    states = tuple(("plant", f"x{number}", -1) for number in range(size))
    return OpenLoop(PeriodMap(states, WIRE, WIRE, matrix, {"gain": by_gain}, 0.0), continuous=True)


def test_slopes_of_margins_are_exact() -> None:
    """K / (s / 10 + 1)^3: -180 deg at 10 sqrt(3) rad/s, where |L| = K / 8; |L| = 1 at 10 sqrt(K^(2/3) - 1)."""
    gain = 3.0
    loop = lags(gain, 3)
    limits = margins_of(loop, "main", "plant.output")
    root = math.sqrt(gain ** (2.0 / 3.0) - 1.0)
    left, crossover = math.pi - 3.0 * math.atan(root), 10.0 * root
    faster = 10.0 * gain ** (-1.0 / 3.0) / (3.0 * root)  # of the crossover, by K
    turned = -3.0 / (1.0 + root**2) * faster / 10.0
    expected = {
        "gain_margin": (20.0 * math.log10(8.0 / gain), -20.0 / math.log(10.0) / gain),
        "phase_margin": (math.degrees(left), math.degrees(turned)),
        "delay_margin": (left / crossover, (turned - left / crossover * faster) / crossover),
    }
    for figure, (value, slope) in expected.items():
        found = read_figure(limits, loop, figure, {"gain": gain})
        assert found.value == pytest.approx(value, rel=1e-12), figure
        assert found.slopes == {"gain": pytest.approx(slope, rel=1e-12)}, figure


def test_the_slope_of_a_margin_downwards() -> None:
    """K (s / 10 + 1)^2 / (s / 10)^3 is stable above K = 1 / 2: it is -2 K at 10 rad/s."""
    gain = 3.0
    matrix, by_gain = np.zeros((4, 5)), np.zeros((4, 5))
    matrix[:3] = 10.0 * np.array([[0, 0, 0, 1, 0], [1, 0, 0, 0, 0], [0, 1, 0, 0, 0]])
    by_gain[3, :3] = -1.0, -2.0, -1.0
    states = tuple(("plant", f"x{number}", -1) for number in range(3))
    moved = PeriodMap(states, WIRE, WIRE, matrix + gain * by_gain, {"gain": by_gain}, 0.0)
    loop = OpenLoop(moved, continuous=True)
    found = read_figure(margins_of(loop, "main", "plant.output"), loop, "gain_margin", {"gain": gain})
    assert found.value == pytest.approx(20.0 * math.log10(2.0 * gain), rel=1e-12)
    assert found.slopes == {"gain": pytest.approx(20.0 / math.log(10.0) / gain, rel=1e-9)}


def test_the_slope_of_a_sensitivity_that_is_largest_at_rest() -> None:
    """L = -0.5 / (s / 10 + 1): |S| = 1 / (1 - 0.5) at rest, where the integral beside it is infinite."""
    loop = lags(-0.5, 1, aside=1)
    found = read_figure(margins_of(loop, "main", "plant.output"), loop, "sensitivity_peak", {"gain": -0.5})
    assert found.value == pytest.approx(20.0 * math.log10(2.0), rel=1e-12)
    assert found.slopes == {"gain": pytest.approx(-20.0 / math.log(10.0) / 0.5, rel=1e-8)}


@pytest.mark.exhaustive
@pytest.mark.defect("S785", before="each slope by two searches for all margins, 0.5 s a parameter", after="by vectors")
def test_slopes_of_a_loop_with_several_values_are_those_of_changed_graphs() -> None:
    """Margins of the graph with a parameter a little larger and smaller tell the slope, whatever the matrices do."""
    graph, name, step = tracking(8), "proportional.gain", 1e-4 * PROPORTIONAL
    system = OperatingPoints(plan(graph)).loop(("angle", "output"), by_parameters=True)
    assert system.per_period == 8
    found = margins_of(system, "main", "angle.output")
    ends = [margins(graph.with_parameters({name: PROPORTIONAL + side * step})) for side in (1.0, -1.0)]
    for figure in ("gain_margin", "phase_margin", "sensitivity_peak", "disk_margin"):
        above, below = (value_of_figure(end, figure) for end in ends)
        reading = read_figure(found, system, figure, {name: PROPORTIONAL})
        assert reading.slopes == {name: pytest.approx((above - below) / (2.0 * step), rel=1e-5)}, figure
    assert read_figure(found, system, "delay_margin", {name: PROPORTIONAL}).slopes == {name: 0.0}


@pytest.mark.defect("S787", before="`worst` and `tune` off by what converters round of a carrier", after="as `margins`")
def test_figures_of_a_search_are_those_of_margins() -> None:
    """A carrier of coarse steps in the loop: it moves with its amplitude, and is rounded all the same."""
    graph = tracking(8)
    blocks = dict(graph.blocks) | {
        "carrier": Sine(frequency=1e4, amplitude=2.4, unit="V"),
        "adc": AnalogToDigital(bits=3, reference=4.0),
        "square": Product(),
    }
    wires = [str(wire) for wire in graph.wires if wire.source != "carrier.output"]
    wires += [
        "carrier.output -> adc.voltage", "adc.number -> square.first", "adc.number -> square.second",
        "square.output -> error.second",
    ]  # fmt: skip
    coarse = Graph(name="coarse", rate=RATE, blocks=blocks, wires=wires, loops={"main": {"open_at": "angle.output"}})
    figures = ("gain_margin", "phase_margin", "disk_margin")
    told = margins(coarse)
    evaluator = Evaluator(
        coarse, {f: LoopFigure("main", f, FIGURES[f]) for f in figures}, "", {"carrier.amplitude": 0.01}
    )
    found = evaluator.readings({"carrier.amplitude": 2.4})
    for figure in figures:
        reading = found[figure]
        assert reading is not None
        assert reading.value == pytest.approx(value_of_figure(told, figure), rel=1e-12)
        assert reading.slopes["carrier.amplitude"] != 0.0


@pytest.mark.defect("S789", before="responses of `worst` and `tune` the same", after="as `response`")
def test_responses_of_a_search_are_those_of_response() -> None:
    """Steps of 1 V of a sine of 2.4 V: 0, 2, 2, 2 and so on, whose squares have the mean 3, not 2.88."""
    blocks = {
        "level": Constant(value=0.0),
        "carrier": Sine(frequency=1e4, amplitude=2.4, unit="V"),
        "adc": AnalogToDigital(bits=3, reference=4.0),
        "square": Product(),
        "turned": Product(),
    }
    wires = [
        "carrier.output -> adc.voltage", "adc.number -> square.first", "adc.number -> square.second",
        "level.output -> turned.first", "square.output -> turned.second",
    ]  # fmt: skip
    graph = Graph(name="coarse", rate=RATE, blocks=blocks, wires=wires)
    figure = ResponseFigure("peak", "turned.output", "level.output", None, "1")
    (found,) = Evaluator(graph, {"peak": figure}, "", {"carrier.amplitude": 0.01}).readings({}).values()
    assert found is not None
    assert found.value == pytest.approx(3.0)
    assert response(graph, "level.output", "turned.output").peak[1] == pytest.approx(3.0)
