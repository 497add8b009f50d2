"""The noise transfer function of a sigma-delta modulator: zeros in the band, maximally flat
outside, one gain there.

With q = 2 cos w0 - 2 cos w, w0 the centre of the band, the poles are those of |H|^2 = q^n / (q^n +
X): flat far from the band. X follows from the gain at the frequency furthest from the centre. The
zeros lie where the power of white noise in the band is least: at the roots of Legendre's polynomial
of this order, stretched to the band (Schreier, IEEE Trans. Circuits and Systems II 40, 1993;
Schreier and Temes, Understanding Delta-Sigma Data Converters, chapter 4).
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import optimize, special

from proofmass.blocks.declaration.problem import ModelError, Problem, did_you_mean
from proofmass.graphs.model.call_numbers import refuse_counts
from proofmass.runner.host.arrays import Array

_brentq: Any = optimize.brentq
ZEROS = ("optimised", "centred", "none")
MOST_ORDER = 8  # beyond it one-bit loops are not stable at a useful gain
_LARGEST = 80.0  # logarithm of the largest X: poles are at zero to rounding


@dataclass(frozen=True)
class NoiseTransfer:
    """A noise transfer function by zeros and poles in z; its first impulse is 1."""

    zeros: tuple[complex, ...]
    poles: tuple[complex, ...]

    def at(self, frequency: Any) -> Array:
        """Return the complex gain at a frequency relative to the rate."""
        z = np.exp(2j * math.pi * np.asarray(frequency, dtype=float))
        terms = [(z - zero) / (z - pole) for zero, pole in zip(self.zeros, self.poles, strict=True)]
        return np.prod(terms, axis=0)  # type: ignore[no-any-return]

    def loop_response(self, length: int) -> Array:
        """Return samples 1 to `length` of the loop filter 1 - 1/H that this function needs."""
        numerator, denominator = np.poly(self.poles).real, np.poly(self.zeros).real
        response = np.zeros(length + 1)
        for n in range(length + 1):
            total = numerator[n] if n < len(numerator) else 0.0
            response[n] = total - sum(
                denominator[k] * response[n - k] for k in range(1, min(n, len(denominator) - 1) + 1)
            )
        return -response[1:]


def synthesised(
    order: int, oversampling: float, gain: float = 1.5, zeros: str = "optimised", centre: float = 0.0
) -> NoiseTransfer:
    """Return the noise transfer function of an order, an oversampling ratio, and a gain far from the band.

    `zeros` are "optimised", "centred" (so, but with two of an even number at the centre), or "none"
    (all at the centre). `centre` is that of the band, relative to the rate; the band is 1 / (2
    oversampling) wide. Raises `ModelError` if that is not possible.

    >>> [round(abs(zero.imag), 4) for zero in synthesised(3, 32).zeros]
    [0.0, 0.076, 0.076]
    """
    _refuse(order, oversampling, zeros, centre)
    angles = 2.0 * math.pi * centre + _spread(order if centre == 0.0 else order // 2, zeros) * _half(
        oversampling, centre
    )
    roots = np.exp(1j * angles)
    roots = roots if centre == 0.0 else np.concatenate([roots, roots.conj()])
    far = -1.0 if centre < 0.25 else 1.0

    def size(log_x: float) -> float:
        return float(np.abs(np.prod((far - roots) / (far - _poles(order, centre, log_x)))))

    most = size(_LARGEST)
    if not 1.0 < gain < most:
        raise refused("must be a gain that this order has", "gain", f"{gain:g}", f"above 1, below {most:.4g}")
    log_x = float(_brentq(lambda log_x: math.log(size(log_x) / gain), -_LARGEST, _LARGEST, xtol=1e-14, rtol=1e-15))
    return NoiseTransfer(_sorted(roots), _sorted(_poles(order, centre, log_x)))


def band(oversampling: float, centre: float) -> tuple[float, float]:
    """Return the ends of the band, relative to the rate."""
    half = 0.5 / oversampling / (1.0 if centre == 0.0 else 2.0)
    return (0.0, half) if centre == 0.0 else (centre - half, centre + half)


def _half(oversampling: float, centre: float) -> float:
    """Return half the width of the band as an angle; of a low pass that from zero to its end."""
    low, high = band(oversampling, centre)
    return math.pi * (high - low) * (2.0 if centre == 0.0 else 1.0)


def _spread(count: int, zeros: str) -> Array:
    """Return zeros between -1 and 1: the polynomial x^m p(x^2) of least power has p Jacobi's of weight t^(m - 1/2)."""
    middle = count if zeros == "none" else count % 2 or (2 if zeros == "centred" else 0)
    pairs = (count - middle) // 2
    if not pairs:
        return np.zeros(count)
    outer = np.sqrt(0.5 * (1.0 + special.roots_jacobi(pairs, 0.0, middle - 0.5)[0]))
    return np.sort(np.concatenate([np.zeros(middle), outer, -outer]))


def _poles(order: int, centre: float, log_x: float) -> Array:
    """Return the roots of q^n = -X inside the unit circle, where z + 1/z = 2 cos w0 - q."""
    turns = np.exp(1j * math.pi * (2.0 * np.arange(order) + 1.0) / order)
    half = math.cos(2.0 * math.pi * centre) - 0.5 * math.exp(log_x / order) * turns
    root = np.sqrt(half * half - 1.0)
    outside = np.where(np.abs(half + root) > np.abs(half - root), half + root, half - root)
    return 1.0 / outside  # type: ignore[no-any-return]


def _sorted(roots: Array) -> tuple[complex, ...]:
    """Return conjugate pairs side by side, by their angle; rounding of real ones is taken away."""
    clean = [complex(root.real, 0.0 if abs(root.imag) < 1e-9 else root.imag) for root in roots]
    return tuple(sorted(clean, key=lambda root: (round(abs(np.angle(root)), 9), root.imag)))


def _refuse(order: int, oversampling: float, zeros: str, centre: float) -> None:
    refuse_counts(order=(order, 1, MOST_ORDER))
    if not oversampling >= 2.0 or not math.isfinite(oversampling):
        raise refused("must be an oversampling ratio", "oversampling", f"{oversampling:g}", "at least 2")
    if zeros not in ZEROS:
        raise refused("must be a way to place zeros", "zeros", zeros, ", ".join(ZEROS), did_you_mean(zeros, ZEROS, ""))
    if centre and (order % 2 or not 0.25 / oversampling < centre < 0.5 - 0.25 / oversampling):
        expected = "an even order" if order % 2 else "a band between 0 and half the rate"
        raise refused("cannot be the centre of a band pass", "centre", f"{centre:g}", expected)


def refused(message: str, key: str, got: str, expected: str = "", hint: str = "") -> ModelError:
    """Return the error of an argument of a design."""
    return Problem(message=message, key=key, got=got, expected=expected, hint=hint).error
