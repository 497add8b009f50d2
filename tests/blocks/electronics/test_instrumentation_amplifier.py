"""The amplifier's gain by its resistors, and what their drift does to it."""

import pytest

from proofmass.blocks import InstrumentationAmplifier
from tests.by_hand.functions import drive


def gain(block: InstrumentationAmplifier) -> float:
    (row,) = drive(block, [{"voltage": 1.0}])
    return float(row["output"])


def test_gain_of_ten_from_nine_to_one() -> None:
    assert gain(InstrumentationAmplifier()) == 10.0
    assert gain(InstrumentationAmplifier(feedback_resistance=0.0)) == 1.0


def test_minus_200_ppm_of_a_resistor_are_minus_180_of_the_gain() -> None:
    """(G - 1) / G = 0.9: the conjecture for the paper's Table 3, -180.5 ppm [C]."""
    moved = InstrumentationAmplifier(feedback_resistance=90e3 * (1.0 - 200e-6))
    assert gain(moved) / 10.0 - 1.0 == pytest.approx(-180e-6, rel=1e-9)
    other = InstrumentationAmplifier(gain_resistance=10e3 * (1.0 + 200e-6))
    assert gain(other) / 10.0 - 1.0 == pytest.approx(-180e-6, rel=3e-4)
    assert InstrumentationAmplifier.drivable("feedback_resistance")
