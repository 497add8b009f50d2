"""Stable factors and margins of loops with several values of the wire in a period."""

import math

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize

import proofmass
from proofmass.blocks import (
    PID,
    Constant,
    Delay,
    Difference,
    DiscreteIntegrator,
    Gain,
    MatrixStateSpace,
    Sum,
    UnitDelay,
)
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.margins.bracketed import stable_intervals
from tests.by_hand.amounts import chosen
from tests.by_hand.polynomial_loops import sampled_loop


def test_intervals_of_a_growth() -> None:
    """A narrow dip below zero between two places of the grid is found."""
    places = np.linspace(-10.0, 10.0, 41)
    found = list(stable_intervals(lambda x: (x - 1.23) * (x - 1.29), places))
    assert found == [(pytest.approx(1.23, abs=1e-12), pytest.approx(1.29, abs=1e-12))]
    assert list(stable_intervals(lambda x: np.full(len(x), -1.0), places)) == [(-10.0, 10.0)]
    assert list(stable_intervals(lambda x: np.full(len(x), math.inf), places)) == []
    assert list(stable_intervals(lambda x: x * 1e-14, places)) == []


FAST, SLOW = 20_000, 1_000
CURRENT = (6.0, 6000.0)  # proportional and integral part of the fast controller
SPEED = (0.6, 12.0)  # of the slow one


def two_rates() -> Graph:
    """A current loop at 20 kHz within a speed loop at 1 kHz."""
    motor = MatrixStateSpace(input_size=1, transition=(-1000.0, -50.0, 500.0, -1.0), entry=(1000.0, 0.0))
    return Graph(
        name="two rates",
        rate=FAST,
        blocks={
            "reference": Constant(value=0.0),
            "speed_error": Difference(),
            "speed": PID(proportional=SPEED[0], integral=SPEED[1], derivative_gain=0.0),
            "current_error": Difference(),
            "current": PID(proportional=CURRENT[0], integral=CURRENT[1], derivative_gain=0.0),
            "delay": UnitDelay(),
            "motor": motor,
        },
        rates={"speed": SLOW, "speed_error": SLOW},
        wires=[
            "reference.output -> speed_error.first",
            "motor.two -> speed_error.second",
            "speed_error.output -> speed.error",
            "speed.output -> current_error.first",
            "motor.one -> current_error.second",
            "current_error.output -> current.error",
            "current.output -> delay.input",
            "delay.output -> motor.first",
        ],
        loops={"current": {"open_at": "current.output"}},
    )


def radius(factor: complex) -> float:
    """Return the largest pole over a slow period of states (current, speed, voltage, two sums, command)."""
    plant = np.array([[-1000.0, -50.0, 1000.0], [500.0, -1.0, 0.0], [0.0, 0.0, 0.0]])
    hold = scipy.linalg.expm(plant / FAST)
    (proportional, integral), (proportional_speed, integral_speed) = CURRENT, SPEED
    tick = np.zeros((6, 6), complex)
    tick[:2, :3] = hold[:2]
    tick[3, [0, 3, 5]] = -1.0, 1.0, 1.0  # sum of errors of the current, this one included
    tick[2] = factor * (integral / FAST * tick[3])
    tick[2, [0, 5]] += factor * proportional * np.array([-1.0, 1.0])
    tick[4, 4] = tick[5, 5] = 1.0
    slow = np.eye(6, dtype=complex)
    slow[4, 1] = -1.0
    slow[5] = integral_speed / SLOW * slow[4]
    slow[5, 1] -= proportional_speed
    return float(np.max(np.abs(np.linalg.eigvals(np.linalg.matrix_power(tick, FAST // SLOW) @ slow))))


@pytest.mark.defect("C401", before="a critical factor was not reached", after="a gain margin of x 3.254")
def test_a_current_loop_in_a_speed_loop() -> None:
    found = proofmass.margins(two_rates(), "current")
    assert found.system.per_period == FAST // SLOW
    limit = scipy.optimize.brentq(lambda factor: radius(factor) - 1.0, 1.0, 10.0, xtol=1e-13)
    assert found.gain_margin == pytest.approx(limit, rel=1e-9)
    assert found.stable_gains == ((0.0, found.gain_margin),)
    turn = scipy.optimize.brentq(lambda x: radius(np.exp(-1j * x)) - 1.0, 0.1, 2.0, xtol=1e-13)
    assert found.phase_margin == pytest.approx(turn, rel=1e-9)


@pytest.mark.defect("S402", before="stable with no factor at the wire", after="stable with 0 to 0.833")
def test_the_way_back_of_an_unstable_loop() -> None:
    """z^3 (z - 1) + 1.2 f (z^3 + 1) is z^4 + 1 at f = 1 / 1.2."""
    graph = Graph(
        name="a direct path beside a delay",
        rate=1_000,
        blocks={
            "zero": Constant(value=0.0),
            "error": Difference(),
            "integral": DiscreteIntegrator(gain=1200.0, output_unit="1"),
            "delay": Delay(ticks=3),
            "sum": Sum(),
        },
        wires=[
            "zero.output -> error.first",
            "sum.output -> error.second",
            "error.output -> integral.input",
            "integral.output -> delay.input",
            "integral.output -> sum.first",
            "delay.output -> sum.second",
        ],
    )
    found = proofmass.margins(graph, "integral.output")
    assert not found.stable
    assert found.stable_gains == ((0.0, pytest.approx(1.0 / 1.2, rel=1e-9)),)


@pytest.mark.parametrize("number", chosen([3, 6], [n for n in range(12) if n not in (3, 6)]))
def test_stable_factors_of_a_lifted_loop(number: int) -> None:
    """A slow register that counts nothing makes a period of three ticks, and changes no interval of factors."""
    graph, truth = sampled_loop(number)
    source = graph.loops["main"].open_at
    rate = graph.rates[source.partition(".")[0]]
    blocks = {**graph.blocks, "slow": UnitDelay(), "nothing": Gain(gain=0.0), "sum": Sum()}
    wires = [str(wire) for wire in graph.wires if not str(wire).startswith(f"{source} ->")]
    wires += [f"{source} -> sum.first", f"{source} -> slow.input", "slow.output -> nothing.input"]
    wires += ["nothing.output -> sum.second", "sum.output -> error.second"]
    rates = {name: rate for name in blocks if name != "slow"} | {"slow": rate / 3}
    lifted = Graph(name="lifted", rate=rate, rates=rates, blocks=blocks, wires=wires)
    found = proofmass.margins(lifted, "sum.output")
    assert found.system.per_period == 3
    ends = [end for interval in found.stable_gains for end in interval]
    assert ends == pytest.approx([end for interval in truth.stable_gains for end in interval], rel=1e-6)
