"""The part `smith_predictor` in front of a plant of first order with a delay, against its loop in z.

PI controller D = Kp + Ki T z / (z - 1), held plant P = g (1 - a) / (z - a), a delay of d ticks. All of the loop goes
through the controller's output; there L = D P, without the delay. The plant alone has D P z^-d / (1 + D P (1 - z^-d)),
which leaves less room, and without the predictor there is none (Smith, Closer control of loops with dead time, 1957).
"""

import cmath
import itertools
import math
from collections.abc import Callable

import pytest

from proofmass import margins
from proofmass.blocks import PID, Constant, Delay, Difference, Gain, LowPass
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate

PERIOD, DELAY, GAIN, TIME_CONSTANT = 0.01, 10, 2.0, 0.1
KP, KI = 2.0, 20.0
LEFT = math.exp(-PERIOD / TIME_CONSTANT)


def plant() -> dict[str, Block]:
    return {
        "wanted": Constant(value=1.0),
        "actuator": Gain(),
        "plant": LowPass(gain=GAIN, corner_frequency=1.0 / (2.0 * math.pi * TIME_CONSTANT)),
        "transport": Delay(ticks=DELAY),
    }


def predicting(model_gain: float = GAIN) -> Graph:
    part = read_graph(library_file("smith_predictor.toml"))
    values = {
        "gain": model_gain,
        "time_constant": TIME_CONSTANT,
        "proportional": KP,
        "integral": KI,
        "delay": DELAY,
        "control_rate": 100.0,
    }
    return Graph(
        name="a plant with a delay and its predictor",
        rate=100,
        blocks={"controller": part.with_parameters(values), **plant()},
        wires=[
            "wanted.output -> controller.setpoint",
            "transport.output -> controller.measurement",
            "controller.output -> actuator.input",
            "actuator.output -> plant.input",
            "plant.output -> transport.input",
        ],
        probes=["plant.output", "controller.prediction"],
    )


def alone() -> Graph:
    return Graph(
        name="a plant with a delay and a controller",
        rate=100,
        blocks={
            "error": Difference(),
            "controller": PID(proportional=KP, integral=KI, derivative_gain=0.0),
            **plant(),
        },
        wires=[
            "wanted.output -> error.first",
            "transport.output -> error.second",
            "error.output -> controller.error",
            "controller.output -> actuator.input",
            "actuator.output -> plant.input",
            "plant.output -> transport.input",
        ],
        probes=["plant.output"],
    )


def inner(w: float) -> complex:
    z = cmath.exp(1j * w * PERIOD)
    return (KP + KI * PERIOD * z / (z - 1.0)) * GAIN * (1.0 - LEFT) / (z - LEFT)


def outer(w: float) -> complex:
    late = cmath.exp(-1j * w * PERIOD * DELAY)
    return inner(w) * late / (1.0 + inner(w) * (1.0 - late))


def crossovers(loop: Callable[[float], complex]) -> list[float]:
    """Where |L| = 1, by bisection between 2,000 points up to half the rate."""
    grid = [math.pi / PERIOD * k / 2000.0 for k in range(1, 2001)]
    found = list[float]()
    for low, high in itertools.pairwise(grid):
        above = abs(loop(low)) > 1.0
        if (abs(loop(high)) > 1.0) is above:
            continue
        for _ in range(60):
            middle = (low + high) / 2.0
            low, high = (middle, high) if (abs(loop(middle)) > 1.0) is above else (low, middle)
        found.append(low)
    return found


@pytest.mark.exhaustive
def test_the_delay_leaves_the_loop_of_the_controller() -> None:
    answer = margins(predicting(), "controller.output")
    (crossover,) = crossovers(inner)
    assert answer.verdict == "stable"
    assert answer.gain_crossovers == pytest.approx([crossover / (2.0 * math.pi)], rel=1e-9)
    assert answer.phase_margin == pytest.approx(math.pi + cmath.phase(inner(crossover)), rel=1e-9)
    assert margins(alone(), "controller.output").verdict == "unstable"


def test_what_the_plant_has_left() -> None:
    """The least turn of the plant's own loop, either way, and the delay that makes it."""
    answer = margins(predicting(), "actuator.output")
    at = crossovers(outer)
    turns = [math.remainder(math.pi + cmath.phase(outer(w)), 2.0 * math.pi) for w in at]
    assert answer.verdict == "stable"
    assert answer.gain_crossovers == pytest.approx([w / (2.0 * math.pi) for w in at], rel=1e-9)
    assert answer.phase_margin == pytest.approx(min(map(abs, turns)), rel=1e-9)
    late = min((turn % (2.0 * math.pi)) / w for w, turn in zip(at, turns, strict=True))
    assert answer.delay_margin == pytest.approx(late, rel=1e-9)


def test_the_plant_follows_as_if_without_delay() -> None:
    """The prediction is that of a loop without a delay from the first tick on."""
    result = simulate(predicting(), samples=1001)
    state, total, expected = 0.0, 0.0, list[float]()
    for _ in range(1001):
        expected.append(state)
        error = 1.0 - state
        total += KI * PERIOD * error
        state = LEFT * state + GAIN * (1.0 - LEFT) * (KP * error + total)
    assert result["controller.prediction"].values == pytest.approx(expected, abs=1e-12)
    assert result["plant.output"].values == pytest.approx(expected, abs=1e-12)
