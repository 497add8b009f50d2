"""The low-pass: its derivative, and the frequency response that follows from it."""

import cmath
import math

import pytest

from proofmass.blocks.filters.low_pass import LowPass, State, constants, derivative, output


def response(block: LowPass, frequency: float) -> complex:
    c = constants(block, 1e-6)
    a = derivative(c, State(1.0), 0.0).filtered
    b = derivative(c, State(0.0), 1.0).filtered
    return output(c, State(1.0)) * b / (2j * math.pi * frequency - a)


def test_three_decibels_and_45_degrees_at_the_corner() -> None:
    at_corner = response(LowPass(corner_frequency=1234.0, gain=2.5), 1234.0)
    assert abs(at_corner) == pytest.approx(2.5 / math.sqrt(2.0), rel=1e-14)
    assert math.degrees(cmath.phase(at_corner)) == pytest.approx(-45.0, rel=1e-14)


@pytest.mark.parametrize("frequency", [0.0, 1.0, 20e3, 1e6])
def test_against_the_formula(frequency: float) -> None:
    expected = 1.0 / (1.0 + 1j * frequency / 20e3)
    assert response(LowPass(), frequency) == pytest.approx(expected, rel=1e-14)


def test_linear_continuous_and_without_feedthrough() -> None:
    assert LowPass.continuous()
    assert LowPass.linear
    assert LowPass.feedthrough("output") == ()
    c = constants(LowPass(), 1.0)
    assert derivative(c, State(0.3), 0.7).filtered == pytest.approx(
        0.3 * derivative(c, State(1.0), 0.0).filtered + 0.7 * derivative(c, State(0.0), 1.0).filtered, rel=1e-15
    )
