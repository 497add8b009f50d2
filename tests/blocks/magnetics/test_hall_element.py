"""The Hall voltage, and what spinning the current does to the offset."""

import pytest

from proofmass.blocks import HallElement
from tests.by_hand.responses import responses


def test_product_of_current_and_field() -> None:
    block = HallElement(sensitivity=80.0, offset=0.5)
    voltages = responses(block, "voltage", current=[1e-3, -1e-3, 2e-3], field=[0.1, 0.1, -0.05])
    assert voltages == pytest.approx([8.5e-3, -8.5e-3, -7e-3], rel=1e-14)


def test_without_offset_nothing_is_left_without_a_field() -> None:
    assert responses(HallElement(), "voltage", current=[1e-3], field=[0.0]) == [0.0]
