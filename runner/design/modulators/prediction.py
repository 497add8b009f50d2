"""Signal to noise of a modulator without a run: its quantiser as two gains and white noise.

A quantiser of one bit sees a sine of p times the rms of Gaussian noise. It passes the noise with a
gain k, and adds the power s = 1 - U^2/2 - m^2. U = (2/pi)^0.5 p e^-r (I0(r) + I1(r)) is the
amplitude of the sine at the output, r = p^2/4, and m = (2/pi)^0.5 e^-r I0(r) is the noise that
passes. The loop makes of s what the quantiser sees: ||H_k||^2 = 1 + m^2/s, H_k the noise transfer
function at the gain k. Of two such k the larger one is stable. Beyond the largest U with a solution
the loop overloads (Ardalan and Paulos, IEEE Trans. Circuits and Systems 34, 1987; Risbo, Stability
predictions for high-order sigma-delta modulators, 1994). Quantisers of more levels have k = 1, s =
step^2/12.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy import optimize, special

from proofmass.runner.design.modulators.noise_transfer import NoiseTransfer
from proofmass.runner.host.arrays import Array

_brentq: Any = optimize.brentq
_GAINS = np.geomspace(0.02, 20.0, 150)  # of the quantiser: of least growth among them
_UNSTABLE = 1e4  # growth that no quantiser allows
_LEAST = 1e-12  # first coefficient at which rounding decides over stability
_POINTS = 64  # of the integral over the band


def predicted(
    transfer: NoiseTransfer, band: tuple[float, float], amplitudes: Sequence[float], levels: int
) -> tuple[tuple[float | None, ...], float]:
    """Return the ratio in dB at each amplitude, None in overload, and the amplitude where overload begins."""
    if levels > 2:
        noise = (2.0 / (levels - 1)) ** 2 / 12.0 * _in_band(transfer, 1.0, band)
        return tuple(_ratio(a, noise) for a in amplitudes), 1.0
    growth = [_growth(transfer, k) for k in _GAINS]
    least = int(np.argmin(growth))
    limit = _limit(growth[least])
    return tuple(_one_bit(transfer, band, a, _GAINS[least]) if a < limit else None for a in amplitudes), limit


def _one_bit(transfer: NoiseTransfer, band: tuple[float, float], amplitude: float, least: float) -> float | None:
    """Return the ratio at the larger of both gains, above that of least growth, or None."""
    passed, added = _powers(amplitude)
    wanted = 1.0 + passed / added
    if _growth(transfer, least) > wanted:
        return None
    k = _brentq(lambda k: _growth(transfer, k) - wanted, least, _GAINS[-1])
    return _ratio(amplitude, added * _in_band(transfer, k, band))


def _limit(least: float) -> float:
    """Return the amplitude at which the noise that passes needs the least growth."""

    def missing(amplitude: float) -> float:
        passed, added = _powers(amplitude)
        return 1.0 + passed / added - least

    if missing(1e-9) <= 0.0:
        return 0.0
    return 1.0 if missing(1.0) > 0.0 else float(_brentq(missing, 1e-9, 1.0))


def _powers(amplitude: float) -> tuple[float, float]:
    """Return noise that passes the quantiser, and what it adds, at an amplitude of the output."""

    def output(p: float) -> float:
        r = 0.25 * p * p
        return math.sqrt(2.0 / math.pi) * p * float(special.ive(0, r) + special.ive(1, r))

    p = _brentq(lambda p: output(p) - amplitude, 0.0, 1e3)
    passed = 2.0 / math.pi * float(special.ive(0, 0.25 * p * p)) ** 2
    return passed, 1.0 - 0.5 * amplitude * amplitude - passed


def _growth(transfer: NoiseTransfer, k: float) -> float:
    """Return ||H_k||^2, the power of its impulse response; large where the loop is not stable.

    A polynomial after the other is of one order less, its first coefficient positive as long as the
    loop is stable (Astrom, Introduction to Stochastic Control Theory, section 5.2).
    """
    numerator, denominator = _at_gain(transfer, k)
    total = 0.0
    for order in range(len(denominator) - 1, -1, -1):
        if denominator[0] < _LEAST:
            return _UNSTABLE
        part, mirrored = numerator[order] / denominator[0], denominator[order::-1]
        total += part * numerator[order]
        numerator = (numerator - part * mirrored)[:order]
        denominator = (denominator - denominator[order] / denominator[0] * mirrored)[:order]
    return min(total, _UNSTABLE)


def _at_gain(transfer: NoiseTransfer, k: float) -> tuple[Array, Array]:
    """Return numerator and denominator of H_k = N / ((1 - k) N + k D), D of the poles at k = 1."""
    n, d = np.poly(transfer.zeros).real, np.poly(transfer.poles).real
    return n.astype(float), np.asarray((1.0 - k) * n + k * d, dtype=float)


def _in_band(transfer: NoiseTransfer, k: float, band: tuple[float, float]) -> float:
    """Return the part of white noise of power 1 that is in the band, of positive and negative frequencies."""
    numerator, denominator = _at_gain(transfer, k)
    points, weights = np.polynomial.legendre.leggauss(_POINTS)
    half = 0.5 * (band[1] - band[0])
    z = np.exp(2j * math.pi * (0.5 * (band[0] + band[1]) + half * points))
    return 2.0 * half * float(weights @ np.abs(np.polyval(numerator, z) / np.polyval(denominator, z)) ** 2)


def _ratio(amplitude: float, noise: float) -> float:
    return 10.0 * math.log10(0.5 * amplitude * amplitude / noise)
