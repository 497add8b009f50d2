"""Sines inside, at the edge of and outside a band."""

import math

import numpy as np
import pytest
from scipy import signal

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


@pytest.mark.defect(
    "S660", before="the start from zero counts: 92 V in the band of 1 to 100 Hz of a constant of 1 kV", after="none"
)
def test_an_offset_makes_no_transient() -> None:
    """A constant has nothing in a band above zero, and all of itself in one from zero on, from the first value on."""
    constant = [{"input": 1000.0}] * 1000
    assert drive(BandMeter(low=1.0, high=100.0), constant, PERIOD)[-1]["rms"] < 1e-9
    assert drive(BandMeter(high=100.0), constant, PERIOD)[2]["rms"] == pytest.approx(1000.0, rel=1e-12)
    assert drive(BandMeter(high=100.0), constant, PERIOD)[-1]["rms"] == pytest.approx(1000.0, rel=1e-12)


@pytest.mark.parametrize(("skip", "until"), [(0, 700), (300, 700), (300, 900), (700, 2000)])
def test_it_looks_from_its_begin_to_its_end(skip: int, until: int) -> None:
    """Up to 90 Hz, by SciPy from rest."""
    values = [1e-3 * k * math.sin(0.3 * k) for k in range(1000)]
    passed = signal.sosfilt(signal.butter(4, 180.0 * PERIOD, output="sos"), values)[skip:until]
    block = BandMeter(high=90.0, skip=skip, until=until)
    found = drive(block, [{"input": value} for value in [*values, 0.0]], PERIOD)[-1]["rms"]
    assert found == pytest.approx(math.sqrt(float(np.mean(passed**2))), rel=1e-10)


def test_filters_that_begin_settled_are_linear_about_the_first_value() -> None:
    """What follows is that of the signal less its first value, by SciPy from rest."""
    values = [7e5 + 3.0 * math.sin(0.3 * k) + (k > 400) for k in range(2000)]
    sos = [
        signal.butter(4, 2.0 * corner * PERIOD, kind, output="sos") for corner, kind in ((2.0, "high"), (90.0, "low"))
    ]
    rest = np.array(values) - values[0]
    for one in sos:
        rest = signal.sosfilt(one, rest)
    found = drive(BandMeter(low=2.0, high=90.0), [{"input": value} for value in [*values, 0.0]], PERIOD)[-1]["rms"]
    assert found == pytest.approx(math.sqrt(float(np.mean(rest**2))), rel=1e-8)
