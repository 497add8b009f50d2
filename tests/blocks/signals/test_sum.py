"""Values of the sum, with two to four terms."""

import math

from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import Sum
from tests.by_hand.functions import drive

finite = st.floats(-1e300, 1e300)


def total(first: float, second: float, **others: float) -> float:
    unconnected = {name: port.default for name, port in Sum.inputs.items() if port.default is not None}
    return float(drive(Sum(), [{"first": first, "second": second} | unconnected | others])[0]["output"])


@given(finite, finite)
def test_unconnected_terms_change_no_bit(first: float, second: float) -> None:
    expected = first + second
    assert (total(first, second), math.copysign(1.0, total(first, second))) == (expected, math.copysign(1.0, expected))


def test_zeros_keep_their_sign() -> None:
    assert math.copysign(1.0, total(-0.0, -0.0)) == -1.0
    assert math.copysign(1.0, total(0.0, -0.0)) == 1.0


@given(*[st.integers(-(2**50), 2**50)] * 4)
def test_four_terms(first: int, second: int, third: int, fourth: int) -> None:
    found = total(float(first), float(second), third=float(third), fourth=float(fourth))
    assert found == first + second + third + fourth


def test_two_terms_must_be_connected() -> None:
    assert [name for name, port in Sum.inputs.items() if port.default is None] == ["first", "second"]
    assert Sum.feedthrough("output") == ("first", "second", "third", "fourth")
