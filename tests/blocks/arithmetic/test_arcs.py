"""Angles of points whose coordinates are sums of two numbers, against mpmath."""

import math

import mpmath
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from proofmass.blocks.arithmetic.arcs import _angle

low_parts = st.floats(-0.5, 0.5)  # of a last place


@pytest.mark.parametrize("size", [1e-200, 1.0, 1e200])
@pytest.mark.parametrize("near", [0.1, math.atan(0.5), math.atan(1.0), math.atan(2.0), 0.5 * math.pi - 0.1])
@given(st.floats(-0.1, 0.1), low_parts, low_parts)
@example(0.1, 0.5, 0.5)
@example(-0.1, 0.5, 0.5)
@example(-0.09516149752750357, 0.0, 0.5)
def test_an_angle_near_those_of_the_table_holds_more_than_its_first_number(
    near: float, size: float, apart: float, y_part: float, x_part: float
) -> None:
    angle = max(near + apart, 1e-9)
    y, x = size * math.sin(angle), size * math.cos(angle)
    y_low, x_low = y_part * math.ulp(y), x_part * math.ulp(x)
    high, low = _angle(y, y_low, x, x_low)
    with mpmath.workprec(200):
        wrong = mpmath.atan2(mpmath.mpf(y) + y_low, mpmath.mpf(x) + x_low) - high - low
    assert abs(wrong) < 8.0 * 2.0**-53 * (0.24 - math.atan(0.24))  # each count with what bends rounds once
