"""White noise: its deviation from the density, and its spectrum."""

import math

import numpy as np
import pytest
from scipy import signal

from proofmass.blocks import WhiteNoise
from proofmass.blocks.arithmetic.counter_random import normal_deviate
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive


@pytest.mark.parametrize("rate", [100.0, 50000.0])
def test_deviation_is_the_density_over_half_the_rate(rate: float) -> None:
    row = drive(WhiteNoise(density=2.0), [{}], period=1.0 / rate, normal=-1.5)[0]
    assert row["output"] == pytest.approx(-1.5 * 2.0 * math.sqrt(rate / 2.0), rel=4e-16)


@pytest.mark.exhaustive
def test_one_sided_spectrum_is_flat_at_the_density() -> None:
    rate, count = 1000.0, 40_000
    noise = WhiteNoise.output_functions["output"].function
    constants = WhiteNoise.functions["constants"].function(WhiteNoise(density="3 nV/sqrt(Hz)", unit="V"), 1.0 / rate)
    values = np.array([noise(constants, normal_deviate(1, 0, 0, n)) for n in range(count)])
    _, power = signal.welch(values, rate, nperseg=256)
    bands = np.sqrt(power[2:-2].reshape(25, 5).mean(axis=1))  # each of about 5 * 312 averages
    assert np.abs(bands / 3e-9 - 1.0).max() < 0.08
    assert np.sqrt(power[2:-2].mean()) == pytest.approx(3e-9, rel=0.02)


def test_density_has_the_unit_of_the_output_per_root_hertz() -> None:
    assert WhiteNoise(density="2 um/s/sqrt(Hz)", unit="m/s").density == 2e-6
    with pytest.raises(ModelError, match=r"in V/sqrt\(Hz\)"):
        WhiteNoise(density="1 V/Hz", unit="V")
