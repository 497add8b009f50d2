"""Tones of known amplitude and phase, over whole cycles and others, on a large mean."""

import math

import pytest

from proofmass.blocks import ToneMeter
from tests.by_hand.functions import drive

PERIOD = 1e-3


@pytest.mark.parametrize(("skip", "delay"), [(0, 0.0), (7, 0.4e-3)])
@pytest.mark.parametrize("frequency", [10.0, 37.3, 499.0])
def test_amplitude_and_phase(frequency: float, skip: int, delay: float) -> None:
    times = [delay + k * PERIOD for k in range(1000)]
    inputs = [{"input": 1e3 + 0.25 * math.sin(2.0 * math.pi * frequency * t + 0.7)} for t in times]
    row = drive(ToneMeter(frequency=frequency, skip=skip, delay=delay), inputs, PERIOD)[-1]
    assert row["amplitude"] == pytest.approx(0.25, rel=1e-9)
    assert row["phase"] == pytest.approx(0.7, abs=1e-9)


def test_nothing_is_known_of_two_samples() -> None:
    rows = drive(ToneMeter(frequency=100.0), [{"input": 3.0}] * 3, PERIOD)
    assert [row["amplitude"] for row in rows] == [0.0, 0.0, 0.0]


def test_a_tone_of_which_samples_have_no_sine_is_not_known() -> None:
    """A measure refuses a frequency of half the rate; a block that has it gives zero, and `check` a note."""
    rows = drive(ToneMeter(frequency=500.0), [{"input": float((-1) ** k)} for k in range(9)], PERIOD)
    assert [row["amplitude"] for row in rows] == [0.0] * 9
