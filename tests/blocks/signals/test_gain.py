"""Values and units of the gain."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import Gain
from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive

finite = st.floats(allow_nan=False, allow_infinity=False)


@given(finite, finite)
def test_product_with_the_gain(gain: float, value: float) -> None:
    assert drive(Gain(gain=gain), [{"input": value}])[0]["output"] == gain * value


def test_the_gain_carries_the_units_of_both_ports() -> None:
    block = Gain(gain="3 mN/V", input_unit="V", output_unit="N")
    assert block.gain == 3e-3
    assert unit_of(block, type(block).inputs["input"]) == "V"
    assert unit_of(block, type(block).outputs["output"]) == "N"
    with pytest.raises(ModelError, match=r"expected: a number, in N/V"):
        Gain(gain="3 V/N", input_unit="V", output_unit="N")
