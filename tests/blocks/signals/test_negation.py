"""Negation: the same number with the other sign, zero included."""

import math

from hypothesis import given
from hypothesis import strategies as some

from proofmass.blocks import Negation
from tests.by_hand.functions import drive


@given(some.floats(-1e300, 1e300))
def test_the_sign_and_nothing_else(value: float) -> None:
    (row,) = drive(Negation(unit="V"), [{"input": value}])
    assert row["output"] == -value
    assert math.copysign(1.0, row["output"]) == -math.copysign(1.0, value)
