"""Signal to noise of one bit in closed forms."""

import math

import numpy as np
import pytest
from scipy import special

from proofmass.runner.design.modulators.noise_transfer import NoiseTransfer
from proofmass.runner.design.modulators.prediction import _growth, _in_band, _limit, _powers, _ratio


def test_ratios_are_those_of_powers() -> None:
    assert _ratio(0.5, 0.5 * 0.5**2 / 1e6) == pytest.approx(60.0)


def test_a_quantiser_that_sees_noise_alone() -> None:
    """2 / pi of the power of its output is noise that passes, and the rest is added."""
    assert _powers(0.0) == pytest.approx((2.0 / math.pi, 1.0 - 2.0 / math.pi), abs=1e-12)
    signal, (passed, added) = 0.4, _powers(0.4)
    assert passed + added + 0.5 * signal**2 == pytest.approx(1.0)


@pytest.mark.parametrize("size", [0.3, 1.0, 2.5, 6.0])
def test_a_quantiser_that_sees_a_sine_in_noise_of_variance_one(size: float) -> None:
    """Means over a turn: 2 erf(p sin t / sqrt 2) sin t, and of e^(-(p sin t)^2 / 2), whose square counts 2 / pi."""
    sine = np.sin(np.linspace(0.0, 2.0 * math.pi, 4096, endpoint=False))
    amplitude = 2.0 * float(np.mean(special.erf(size * sine / math.sqrt(2.0)) * sine))
    passed = 2.0 / math.pi * float(np.mean(np.exp(-0.5 * (size * sine) ** 2))) ** 2
    assert _powers(amplitude) == pytest.approx((passed, 1.0 - 0.5 * amplitude**2 - passed), rel=1e-9)


def test_overload_begins_where_the_growth_is_what_the_noise_allows() -> None:
    passed, added = _powers(0.6)
    assert _limit(1.0 + passed / added) == pytest.approx(0.6, abs=1e-9)
    assert _limit(1.0 + 2.0 / math.pi / (1.0 - 2.0 / math.pi) + 1e-3) == 0.0


@pytest.mark.parametrize("gain", [0.2, 1.0, 1.9])
def test_power_of_a_transfer_of_first_order(gain: float) -> None:
    """(z - 1) / (z - 1 + k) passes 2 / (2 - k) of white noise, and is stable up to k = 2."""
    transfer = NoiseTransfer((1.0,), (0.0,))
    assert _growth(transfer, gain) == pytest.approx(2.0 / (2.0 - gain), rel=1e-12)
    assert _in_band(transfer, gain, (0.0, 0.5)) == pytest.approx(2.0 / (2.0 - gain), rel=1e-6)
    assert _growth(transfer, 2.1) > 1e3
