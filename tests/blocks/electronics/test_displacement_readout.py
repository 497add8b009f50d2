"""Gain and offset of the readout."""

import pytest

from proofmass.blocks import DisplacementReadout
from tests.by_hand.functions import drive


def voltages(block: DisplacementReadout, displacements: list[float]) -> list[float]:
    return [row["voltage"] for row in drive(block, [{"displacement": x} for x in displacements])]


def test_gain_and_offset() -> None:
    assert voltages(DisplacementReadout(gain=2.0, offset=0.5), [0.0, 1.0, -3.0]) == [0.5, 2.5, -5.5]


def test_volts_per_g_of_the_default_accelerometer() -> None:
    displacement_of_1_g = 50.43e-9 * 9.80665 / 49.5627
    assert voltages(DisplacementReadout(), [displacement_of_1_g]) == pytest.approx([3.52], rel=1e-3)
