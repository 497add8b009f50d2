"""The controller against its difference equation, its frequency response, and at its limits."""

import math

import control
import numpy as np
import pytest
from scipy.signal import lfilter

from proofmass.blocks.control.pid import PID, Constants, State, constants, output, update
from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive

PERIOD = 1.0 / 50e3


def outputs(block: PID, errors: list[float], period: float = PERIOD) -> list[float]:
    return [row["output"] for row in drive(block, [{"error": e} for e in errors], period)]


def test_against_the_difference_equation() -> None:
    block = PID(proportional=0.3, integral=40.0, derivative_gain=1e-4, derivative_pole=900.0)
    errors = np.random.default_rng(71).normal(size=500)
    a = math.exp(-2.0 * math.pi * 900.0 * PERIOD)
    expected = 0.3 * errors
    expected += lfilter([40.0 * PERIOD], [1.0, -1.0], errors)
    expected += lfilter(1e-4 / PERIOD * (1.0 - a) * np.array([1.0, -1.0]), [1.0, -a], errors)
    assert outputs(block, errors.tolist()) == pytest.approx(expected, rel=1e-12, abs=1e-13)


@pytest.mark.parametrize("frequency", [1.0, 50.0, 2000.0, 20e3])
def test_frequency_response_against_control(frequency: float) -> None:
    p = PID()
    c = constants(p, PERIOD)
    nothing = State(0.0, 0.0, 0.0)
    states = [State(*row) for row in np.eye(3)]
    found = control.ss(
        np.array([update(c, x, 0.0) for x in states]).T,
        np.array([update(c, nothing, 1.0)]).T,
        np.array([[output(c, x, 0.0) for x in states]]),
        [[output(c, nothing, 1.0)]],
        PERIOD,
    )
    z = control.tf([1, 0], [1], PERIOD)
    a = math.exp(-2.0 * math.pi * p.derivative_pole * PERIOD)
    expected = p.proportional + p.integral * PERIOD * z / (z - 1)
    expected += p.derivative_gain / PERIOD * (1.0 - a) * (z - 1) / (z - a)
    at = np.exp(2j * math.pi * frequency * PERIOD)
    assert found(at) == pytest.approx(expected(at), rel=1e-9)


def test_each_part_alone_by_hand() -> None:
    nothing = {"proportional": 0.0, "integral": 0.0, "derivative_gain": 0.0}
    step = [1.0] * 4
    assert outputs(PID(**nothing | {"proportional": 2.0}), step, 0.5) == [2.0] * 4
    assert outputs(PID(**nothing | {"integral": 2.0}), step, 0.5) == [1.0, 2.0, 3.0, 4.0]
    decay = math.exp(-2.0 * math.pi * 0.1 * 0.5)
    kick = outputs(PID(**nothing | {"derivative_gain": 2.0, "derivative_pole": 0.1}), step, 0.5)
    assert kick == pytest.approx([4.0 * (1.0 - decay) * decay**n for n in range(4)], rel=1e-14)
    assert sum(kick) / (1.0 - decay**4) == pytest.approx(4.0, rel=1e-13)


def limited(lowest: float = -0.1, highest: float = 0.1) -> PID:
    return PID(limited=True, lowest=lowest, highest=highest, derivative_gain=0.0)


def last_state(block: PID, errors: list[float]) -> tuple[Constants, State]:
    c, x = constants(block, 1e-3), State(0.0, 0.0, 0.0)
    for e in errors:
        x = update(c, x, e)
    return c, x


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_integral_stays_bounded_and_the_output_recovers_at_once(sign: float) -> None:
    errors = [sign] * 10_000
    c, x = last_state(limited(), errors)
    assert output(c, x, sign) == sign * 0.1
    assert abs(x.integral) <= 0.1 + abs(c.integral)
    assert abs(output(c, x, -sign)) < 0.1
    _, free = last_state(PID(derivative_gain=0.0), errors)
    assert abs(free.integral) == pytest.approx(60.0, rel=1e-9)


def test_an_error_that_drives_the_integral_back_is_taken() -> None:
    c, x = constants(limited(), 1e-3), State(5.0, 0.0, 0.0)
    assert output(c, x, -1.0) == 0.1
    assert update(c, x, -1.0).integral == 5.0 - 6.0e-3
    assert update(c, x, 1.0).integral == 5.0


def test_limits_far_away_change_no_bit() -> None:
    errors = np.random.default_rng(7).normal(size=200).tolist()
    assert outputs(PID(limited=True, lowest=-1e6, highest=1e6), errors) == outputs(PID(), errors)


def test_limits_in_the_wrong_order_are_refused() -> None:
    with pytest.raises(ModelError, match="expected: less than highest = -2"):
        PID(highest=-2.0)


def test_feedthrough_and_units() -> None:
    block = PID(input_unit="V", output_unit="A", integral="5 mA/V/ms")
    assert block.integral == 5.0
    assert PID.feedthrough("output") == ("error",)
    assert unit_of(block, type(block).outputs["output"]) == "A"
