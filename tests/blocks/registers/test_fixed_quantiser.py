"""The quantiser against fractions for every rounding, also where floating point is at its limits; its own count."""

import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import FixedQuantiser
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.fixed_point import ROUNDINGS, cast
from tests.by_hand.functions import drive

formats = st.builds(Fixed, st.integers(1, 50), st.integers(-10, 60), st.booleans())
numbers = st.floats(-1e5, 1e5) | st.builds(lambda m, f: math.ldexp(m, -f), st.integers(-4000, 4000), st.integers(0, 14))


@given(numbers, formats, st.sampled_from(ROUNDINGS), st.sampled_from(["saturate", "wrap"]))
def test_against_fractions(number: float, target: Fixed, rounding: str, overflow: str) -> None:
    if abs(number) * 2.0**target.fraction >= 2.0**61:
        overflow = "saturate"  # the input is clipped at 2^62 steps before it could wrap
    block = FixedQuantiser(output_format=target, rounding=rounding, overflow=overflow)
    assert drive(block, [{"input": number}]) == [{"output": cast(Fraction(number), target, rounding, overflow)}]


@pytest.mark.parametrize("rounding", ROUNDINGS)
def test_numbers_next_to_a_tie(rounding: str) -> None:
    block = FixedQuantiser(output_format=Fixed(60, 0), rounding=rounding)
    ties = [sign * (n + 0.5) for n in (0, 1, 2, 2**51, 2**52 - 1) for sign in (1.0, -1.0)]
    near = [math.nextafter(tie, towards) for tie in ties for towards in (-math.inf, tie, math.inf)]
    near += [5e-324, -5e-324, 0.0, -0.0, 2.0**53 + 2.0, -(2.0**55)]
    found = [row["output"] for row in drive(block, [{"input": number} for number in near])]
    assert found == [cast(Fraction(number), Fixed(60, 0), rounding, "saturate") for number in near]


def test_it_counts_what_did_not_fit() -> None:
    block = FixedQuantiser(output_format=Fixed(8, 4))
    inputs = [0.0, 7.9, 7.96, 7.97, -8.0, -8.03, -8.04, 1e300, -math.inf]
    update, start = type(block).functions["update"].function, [0]
    c = type(block).functions["constants"].function(block, 1.0)
    state = type(block).state_class()(*start)  # type: ignore[misc]
    counts = []
    for number in inputs:
        state = update(c, state, number)
        counts.append(state.overflows)
    assert counts == [0, 0, 0, 1, 1, 1, 2, 3, 4]


def test_a_format_that_int64_does_not_hold_is_refused() -> None:
    with pytest.raises(ModelError, match="at most 62 bits"):
        FixedQuantiser(output_format="(63, 0)")
