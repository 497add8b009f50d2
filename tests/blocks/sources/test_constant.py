"""The constant stays, in the unit that it was given in."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import Constant
from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_the_value_in_every_tick(value: float) -> None:
    assert [row["output"] for row in drive(Constant(value=value), [{}] * 3)] == [value] * 3


def test_the_value_is_read_in_the_unit_of_the_block() -> None:
    block = Constant(value="1 mg0", unit="m/s^2")
    assert block.value == 9.80665e-3
    assert unit_of(block, type(block).outputs["output"]) == "m/s^2"
    with pytest.raises(ModelError, match="V is"):
        Constant(value="1 V", unit="m/s^2")
