"""The two levels of the one-bit actuator."""

import pytest

from proofmass.blocks import OneBitActuator
from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive


def test_one_is_plus_the_level_and_zero_is_minus() -> None:
    rows = drive(OneBitActuator(), [{"bit": bit} for bit in (True, False, False, True)])
    assert [row["output"] for row in rows] == [1.0e-6, -1.0e-6, -1.0e-6, 1.0e-6]


def test_unit_and_level_go_together() -> None:
    block = OneBitActuator(unit="V", level="1694 mV")
    assert block.level == 1.694
    assert unit_of(block, type(block).outputs["output"]) == "V"
    with pytest.raises(ModelError, match=r"hint: +give it in N"):
        OneBitActuator(level="1.694 V")


def test_no_level_is_refused() -> None:
    with pytest.raises(ModelError, match="must be > 0"):
        OneBitActuator(level=0.0)
