"""The sine wave against mpmath and at its exact points."""

import math

import mpmath
import pytest

from proofmass.blocks import Sine
from tests.by_hand.functions import drive


@pytest.mark.parametrize("frequency", [90.0, 1234.5, 24000.0])
def test_against_mpmath_over_many_periods(frequency: float) -> None:
    period = 1.0 / 50000.0
    block = Sine(amplitude=9.80665, frequency=frequency, phase=0.75, offset=-1.5)
    for tick, row in enumerate(drive(block, [{}] * 2000, period)):
        turns = mpmath.mpf(frequency) * mpmath.mpf(tick * period) + mpmath.mpf(0.75) / (2 * mpmath.pi)
        exact = -1.5 + 9.80665 * mpmath.sinpi(2 * turns)
        rounding = 9.80665 * 2 * math.pi * math.ulp(frequency * tick * period + 1.0)
        assert abs(row["output"] - exact) < rounding + 4e-15


def test_exact_at_quarters_of_a_period_for_a_million_periods() -> None:
    sine = Sine.output_functions["output"].function
    constants = Sine.functions["constants"].function(Sine(amplitude=2.0, frequency=0.25), 1.0)
    for tick in (0, 1, 2, 3, 4_000_001, 4_000_002, 4_000_003):
        assert sine(constants, float(tick)) == (0.0, 2.0, 0.0, -2.0)[tick % 4]


def test_phase_is_given_in_degrees_too() -> None:
    assert drive(Sine(phase="90 deg"), [{}])[0]["output"] == 1.0
