"""Elementary functions against mpmath, at their exact points, and compiled to the same bits."""

import math
from collections.abc import Callable

import mpmath
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from proofmass.blocks.arithmetic.elementary import (
    cosine_of_turns,
    exponential,
    logarithm_of_fraction,
    logarithm_of_one_plus,
    sine_of_turns,
)
from tests.by_hand.compiled import compiled

turns = st.one_of(
    st.floats(-(2.0**50), 2.0**50),
    st.floats(-1.0, 1.0),
    st.builds(lambda quarters, small: 0.25 * quarters + small, st.integers(-8, 8), st.floats(-1e-9, 1e-9)),
)


def ulps(got: float, exact: mpmath.mpf) -> float:
    """The error of a number in units of the last place of the exact value."""
    return float(abs(mpmath.mpf(got) - exact) / mpmath.mpf(math.ulp(float(exact))))


@given(turns)
@example(0.08116843120388742)
@example(5e-324)
def test_sine_within_1_3_ulp(turns: float) -> None:
    with mpmath.workprec(1200):
        exact = mpmath.sinpi(2 * mpmath.mpf(turns))
        assert ulps(sine_of_turns(turns), exact) < (1.3 if abs(exact) > 1e-300 else 2.0)
    assert abs(sine_of_turns(turns)) <= 1.0


@given(turns)
@example(0.1183688232023599)
def test_cosine_within_1_6_ulp(turns: float) -> None:
    with mpmath.workprec(200):
        assert ulps(cosine_of_turns(turns), mpmath.cospi(2 * mpmath.mpf(turns))) < 1.6
    assert abs(cosine_of_turns(turns)) <= 1.0


@given(turns)
def test_sine_is_odd_and_cosine_even(turns: float) -> None:
    assert sine_of_turns(-turns) == -sine_of_turns(turns)
    assert cosine_of_turns(-turns) == cosine_of_turns(turns)


@given(st.integers(-(2**48), 2**48))
def test_exact_at_every_quarter_turn(quarters: int) -> None:
    assert sine_of_turns(0.25 * quarters) == (0.0, 1.0, 0.0, -1.0)[quarters % 4]
    assert cosine_of_turns(0.25 * quarters) == (1.0, 0.0, -1.0, 0.0)[quarters % 4]


@given(st.one_of(st.floats(2.0**-64, 1.0), st.floats(0.0, 64.0).map(lambda octaves: 2.0**-octaves)))
@example(0.7015118033766384)
@example(1.0 - 2.0**-53)
def test_logarithm_within_0_9_ulp(value: float) -> None:
    with mpmath.workprec(200):
        assert ulps(logarithm_of_fraction(value), mpmath.log(mpmath.mpf(value))) < 0.9


@given(st.one_of(st.floats(0.0, 2.0**63), st.floats(-300.0, 18.9).map(lambda decades: 10.0**decades)))
@example(0.4025218609757173)
@example(0.41421356237309515)
def test_logarithm_of_one_plus_within_1_ulp(value: float) -> None:
    with mpmath.workprec(3000):
        exact = mpmath.log1p(mpmath.mpf(value))
        assert ulps(logarithm_of_one_plus(value), exact) < 1.0


@given(st.one_of(st.floats(-354.0, 354.0), st.floats(-1.0, 1.0)))
@example(-25.99242316005818)
def test_exponential_within_1_ulp(value: float) -> None:
    with mpmath.workprec(200):
        assert ulps(exponential(value), mpmath.exp(mpmath.mpf(value))) < 1.0


def test_exponential_is_held_at_both_ends_and_hides_no_nan() -> None:
    assert exponential(math.inf) == exponential(354.0) == pytest.approx(math.exp(354.0), rel=3e-16)
    assert exponential(-math.inf) == exponential(-354.0) == pytest.approx(math.exp(-354.0), rel=3e-16)
    assert math.isnan(exponential(math.nan))


ALL = [sine_of_turns, cosine_of_turns, logarithm_of_fraction, logarithm_of_one_plus, exponential]


@pytest.mark.parametrize("function", ALL)
def test_compiled_to_the_same_bits(function: Callable[[float], float]) -> None:
    fast = compiled(function)
    values = (np.random.default_rng(1).uniform(2.0**-10, 1.0, 5000) ** 4.0).tolist()
    assert [function(value) for value in values] == [fast(value) for value in values]
