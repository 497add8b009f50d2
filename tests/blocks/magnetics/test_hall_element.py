"""The Hall voltage, and what spinning the current does to the offset."""

import pytest
from scipy.constants import elementary_charge

from proofmass.blocks import HallElement
from tests.by_hand.responses import responses


def test_product_of_current_and_field() -> None:
    block = HallElement(sensitivity=80.0, offset=0.5)
    voltages = responses(block, "voltage", current=[1e-3, -1e-3, 2e-3], field=[0.1, 0.1, -0.05])
    assert voltages == pytest.approx([8.5e-3, -8.5e-3, -7e-3], rel=1e-14)


def test_without_offset_nothing_is_left_without_a_field() -> None:
    assert responses(HallElement(), "voltage", current=[1e-3], field=[0.0]) == [0.0]


@pytest.mark.derivation(
    HallElement,
    equation="voltage = (sensitivity field + offset) current",
    source="balance of the forces on electrons that drift through a plate of GaAs of 0.6 um, 1e23 per m^3",
    convention="field across the plate; voltage across the whole width; the offset goes with the current",
)
def test_electrons_that_drift_through_a_plate() -> None:
    density, thick, width, current, field = 1e23, 0.6e-6, 80e-6, 2e-3, -0.03
    drift = current / (density * elementary_charge * thick * width)
    sideways = drift * field * width
    block = HallElement(sensitivity=1.0 / (density * elementary_charge * thick), offset=0.7)
    forth, back = responses(block, "voltage", current=[current, -current], field=[field] * 2)
    assert forth - 0.7 * current == pytest.approx(sideways, rel=1e-12)
    assert back == pytest.approx(-forth, rel=1e-12)
    assert HallElement().sensitivity == pytest.approx(1.0 / (density * elementary_charge * thick), rel=0.05)
