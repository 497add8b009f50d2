"""Poles and zeros of prototypes against scipy.signal and scipy.special."""

import cmath
import math

import numpy as np
import pytest
from scipy import signal, special

from proofmass.blocks.arithmetic import prototypes
from proofmass.blocks.arithmetic.elliptic import elliptic, mean, modulus
from proofmass.blocks.arithmetic.prototypes import Prototype


def poles_and_zeros(p: Prototype, order: int) -> tuple[list[complex], list[float]]:
    """Poles in the upper half plane, and zeros above zero, by size."""
    poles, zeros = [], []
    for i in range((order + 1) // 2):
        w, q, z = p[1 + 3 * i : 4 + 3 * i]
        poles.append(-w + 0j if 2 * i + 1 == order else w * complex(-0.5 / q, cmath.sqrt(1.0 - 0.25 / q**2).real))
        if z:
            zeros.append(1.0 / z)
    return sorted(poles, key=lambda v: v.imag), sorted(zeros)


@pytest.mark.parametrize("order", range(1, 9))
def test_against_scipy(order: int) -> None:
    for made, (z, p, k) in {
        prototypes.butterworth(order): signal.buttap(order),
        prototypes.bessel(order): signal.besselap(order, norm="mag"),
        prototypes.chebyshev_type1(order, 0.2): signal.cheb1ap(order, 0.2),
        prototypes.chebyshev_type2(order, 35.0): signal.cheb2ap(order, 35.0),
        elliptic(order, 0.3, 55.0): signal.ellipap(order, 0.3, 55.0),
    }.items():
        poles, zeros = poles_and_zeros(made, order)
        upper = sorted((v for v in np.ravel(p) if v.imag > -1e-12), key=lambda v: v.imag)
        assert poles == pytest.approx(upper, rel=3e-14, abs=1e-14)
        assert zeros == pytest.approx(sorted(v.imag for v in np.ravel(z) if v.imag > 1e-12), rel=3e-14)
        at_rest = k * np.prod(-np.asarray(z)) / np.prod(-np.asarray(p))
        assert made.gain == pytest.approx(abs(at_rest), rel=1e-13)


@pytest.mark.parametrize("k", [0.01, 0.3, 0.7, 0.97])
def test_modulus_and_mean(k: float) -> None:
    other = math.sqrt((1.0 - k) * (1.0 + k))
    assert 0.5 * math.pi / mean(1.0, other) == pytest.approx(special.ellipk(k * k), rel=1e-14)
    nome = math.exp(-math.pi * special.ellipkm1(k * k) / special.ellipk(k * k))
    assert modulus(nome) == pytest.approx((k, other), rel=3e-14)
