"""Sines inside, at the edge of and outside a band."""

import math

import pytest

from proofmass.blocks import BandMeter
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive

PERIOD = 1e-3
SKIP = 1000


def rms(frequency: float, mean: float = 0.0, **band: float) -> float:
    inputs = [{"input": mean + math.sin(2.0 * math.pi * frequency * k * PERIOD)} for k in range(SKIP + 1001)]
    return float(drive(BandMeter(skip=SKIP, **band), inputs, PERIOD)[-1]["rms"])


def test_a_sine_inside_the_band_passes() -> None:
    assert rms(30.0, low=5.0, high=200.0) == pytest.approx(math.sqrt(0.5), rel=1e-3)


@pytest.mark.parametrize(("low", "high"), [(30.0, 300.0), (2.0, 30.0)])
def test_at_its_ends_it_is_down_by_3_db(low: float, high: float) -> None:
    assert rms(30.0, low=low, high=high) == pytest.approx(0.5, rel=2e-3)


@pytest.mark.parametrize(("low", "high"), [(120.0, 400.0), (1.0, 7.5)])
def test_two_octaves_outside_it_is_down_by_48_db(low: float, high: float) -> None:
    assert rms(30.0, low=low, high=high) < math.sqrt(0.5) * 10.0 ** (-46.0 / 20.0)


def test_from_zero_on_the_mean_counts() -> None:
    assert rms(30.0, mean=2.0, high=200.0) == pytest.approx(math.sqrt(4.5), rel=1e-3)
    assert rms(30.0, mean=2.0, low=3.0, high=200.0) == pytest.approx(math.sqrt(0.5), rel=2e-2)


def test_a_band_that_ends_before_it_begins_is_refused() -> None:
    with pytest.raises(ModelError, match="above low, 50 Hz"):
        BandMeter(low=50.0, high=20.0)
