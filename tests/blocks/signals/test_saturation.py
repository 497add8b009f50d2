"""Limits of the saturation."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import Saturation
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive

finite = st.floats(allow_nan=False, allow_infinity=False)


def limited(block: Saturation, value: float) -> float:
    return float(drive(block, [{"input": value}])[0]["output"])


@given(finite)
def test_inside_it_is_the_input_and_outside_the_nearer_limit(value: float) -> None:
    assert limited(Saturation(lowest=-2.5, highest=4.0), value) == min(max(value, -2.5), 4.0)


def test_at_and_next_to_the_limits() -> None:
    block = Saturation(lowest=0.0, highest=3.0)
    assert [limited(block, v) for v in (0.0, 5e-324, 3.0, 2.9999999999999996, -5e-324)] == [
        0.0,
        5e-324,
        3.0,
        2.9999999999999996,
        0.0,
    ]


@pytest.mark.parametrize("lowest", [1.0, 2.0])
def test_limits_in_the_wrong_order_are_refused(lowest: float) -> None:
    with pytest.raises(ModelError) as error:
        Saturation(lowest=lowest)
    assert str(error.value) == (
        "Saturation.lowest: does not go with the other parameters\n"
        f"  got:      {lowest}\n"
        "  expected: less than highest = 1"
    )
