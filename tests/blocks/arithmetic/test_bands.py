"""Band-pass and band-stop sections against scipy.signal, pole by pole and over the frequencies."""

import math
from typing import Any

import numpy as np
import pytest
from scipy import signal

from proofmass.blocks.arithmetic import prototypes
from proofmass.blocks.arithmetic.bands import LARGEST_BAND_ORDER, banded
from proofmass.blocks.arithmetic.elliptic import elliptic
from proofmass.blocks.arithmetic.prototypes import Prototype

RATE = 1000.0
COPY = (1.0, 0.0, 0.0, 0.0, 0.0)
BANDS = [(40.0, 90.0), (123.0, 125.0), (5.0, 430.0), (300.0, 480.0)]


def prototype_of(shape: str, order: int) -> tuple[Prototype, Any]:
    """Return a prototype, and zeros, poles and gain of the same by scipy."""
    return {
        "butterworth": lambda: (prototypes.butterworth(order), signal.buttap(order)),
        "bessel": lambda: (prototypes.bessel(order), signal.besselap(order, norm="mag")),
        "chebyshev_type1": lambda: (prototypes.chebyshev_type1(order, 0.7), signal.cheb1ap(order, 0.7)),
        "chebyshev_type2": lambda: (prototypes.chebyshev_type2(order, 33.0), signal.cheb2ap(order, 33.0)),
        "elliptic": lambda: (elliptic(order, 0.4, 45.0), signal.ellipap(order, 0.4, 45.0)),
    }[shape]()


def sorted_pairs(values: Any) -> Any:
    return np.sort_complex(np.round(values, 13))


@pytest.mark.parametrize("stop", [False, True])
@pytest.mark.parametrize("order", range(1, LARGEST_BAND_ORDER + 1))
@pytest.mark.parametrize("shape", ["butterworth", "bessel", "chebyshev_type1", "chebyshev_type2", "elliptic"])
def test_poles_zeros_and_response(shape: str, order: int, stop: bool) -> None:
    made, analog = prototype_of(shape, order)
    for low, high in BANDS:
        t1, t2 = (math.tan(math.pi * f / RATE) for f in (low, high))
        turned = (signal.lp2bs_zpk if stop else signal.lp2bp_zpk)(*analog, wo=math.sqrt(t1 * t2), bw=t2 - t1)
        zeros, poles, gain = signal.bilinear_zpk(*turned, fs=0.5)
        sections = np.reshape(banded(made, order, stop, low, high, 1.0 / RATE), (4, 5))
        used = sections[: order + order % 2] if order % 2 == 0 else sections[:order]
        assert all(tuple(row) == COPY for row in sections[len(used) :])
        assert np.count_nonzero((sections != COPY).any(axis=1)) == order
        found = np.concatenate([np.roots([1.0, *row[3:]]) for row in used])
        assert np.abs(sorted_pairs(found) - sorted_pairs(poles)).max() < 1e-6
        w = 2.0 * math.pi * np.array([0.0, *np.geomspace(1.0, 499.0, 60), low, high, 500.0]) / RATE
        z = np.exp(-1j * w)
        answer = np.prod([np.polyval(row[2::-1], z) / np.polyval([row[4], row[3], 1.0], z) for row in used], axis=0)
        expected = signal.freqz_zpk(zeros, poles, gain, w)[1]
        assert np.abs(answer - expected).max() < 1e-9


@pytest.mark.parametrize("stop", [False, True])
def test_a_very_narrow_band_keeps_its_digits(stop: bool) -> None:
    """Poles at a distance of 1e-9 from the circle: their distance is known to seven digits, and more than 1e-16."""
    low, high = 100.0, 100.0 * (1.0 + 1e-8)
    sections = np.reshape(banded(prototypes.butterworth(1), 1, stop, low, high, 1.0 / RATE), (4, 5))
    b = math.tan(math.pi * high / RATE) - math.tan(math.pi * low / RATE)
    t1t2 = math.tan(math.pi * low / RATE) * math.tan(math.pi * high / RATE)
    assert 1.0 - sections[0, 4] == pytest.approx(2.0 * b / (1.0 + b + t1t2), rel=1e-6)
