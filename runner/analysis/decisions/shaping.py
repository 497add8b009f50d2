"""Filters that give white noise the spectrum of the error of a quantiser, fitted to that of a run.

All-pole models by linear prediction (Makhoul, Proc. IEEE 63, 1975, 561), first on an axis of
frequency that is stretched at low frequencies, where decimation listens, and then, of what is left,
on the axis as it is:

    1 / A(D(z)),   D(z) = (z^-1 - w) / (1 - w z^-1)

(Strube, J. Acoust. Soc. Am. 68, 1980, 1071). A pole p of the first is one at (w + p) / (1 + w p),
with a zero at w.
"""

import cmath
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
import scipy.special

from proofmass.runner.analysis.linearisation.wire_response import Matrices
from proofmass.runner.analysis.spectrum.welch import spectrum
from proofmass.runner.host.arrays import Array, Complex

_Pole = tuple[complex, float]  # and the zero that goes with it

_SEGMENTS = 64  # of a run that a spectrum is the mean of, without those that overlap
_LONGEST = 1 << 16
_ORDER, _LOW_ORDER = 64, 48  # of the models, at most
_LINES = 16  # of a spectrum, for each pole at least
_STRETCH = 4e-3  # lines of a segment, from which on low frequencies are stretched
_BANDS = 3  # an octave
_LEAST = 8  # lines of a band
_NEAR = (0.0, 0.3, 1.0, 3.0)  # of the width of a pole, from its middle
_NOTHING = 1e-17  # of the rms of states
_TESTED = 1 << 18  # values, at most
_DOUBT = 1e-3  # probability that white noise fails the test


@dataclass(frozen=True)
class Shaping:
    """A filter without unit: the product of (1 - zero z^-1) / (1 - pole z^-1), times a gain. Its output has rms 1."""

    gain: float
    poles: tuple[_Pole, ...]  # real ones, and of a conjugate pair that above the axis

    def matrices(self) -> Matrices:
        """Return A, B, C and D of one value. White noise of rms 1 gives every state the rms 1, and
        no two are related.

        So A never makes a state longer, over any number of values. The states are those of a
        cascade of all-pass sections (Heuberger, Van den Hof and Bosgra, IEEE Trans. Automatic
        Control 40, 1995, 451).
        """
        a, b, through = np.zeros((0, 0)), np.zeros((0, 1)), np.ones((1, 1))
        last = np.zeros((1, 0))
        for pole, _ in self.poles:
            f, g, h, k = _all_pass(pole)
            a = np.block([[a, np.zeros((len(a), len(f)))], [g @ last, f]])
            b, last, through = np.vstack([b, g @ through]), np.hstack([k * last, h]), k * through
        return a, b, self._read()[None], np.full((1, 1), self.gain)

    def _read(self) -> Array:
        """Return C, by the response at more frequencies than there are states, some of them near each pole."""
        angles = np.linspace(0.0, math.pi, 8 * len(self.poles) + 2)[1:-1]
        near = np.array([abs(cmath.phase(pole)) + k * (1.0 - abs(pole)) for pole, _ in self.poles for k in _NEAR])
        z = np.exp(1j * np.concatenate([angles, near[(near > 0.0) & (near < math.pi)]]))
        states, entry = [], np.ones(len(z), dtype=complex)
        for pole, _ in self.poles:
            a, b, c, d = _all_pass(pole)
            resolvent = z[:, None, None] * np.eye(len(a)) - a
            x = np.linalg.solve(resolvent, np.broadcast_to(b + 0j, (len(z), *b.shape)))[:, :, 0] * entry[:, None]
            states.append(x)
            entry = x @ c[0] + d * entry
        rows: Complex = np.hstack(states)
        wanted = self._response(z) - self.gain
        parts = np.vstack([rows.real, rows.imag]), np.concatenate([wanted.real, wanted.imag])
        solved: Any = scipy.linalg.lstsq(*parts, lapack_driver="gelsy")
        return np.asarray(solved[0])

    def over(self, values: int) -> Matrices:
        """Return A, B, C and D of so many values in a row."""
        a, b, c, d = self.matrices()
        rows, columns, answer = [c], [b], [d[0, 0]]
        for _ in range(values - 1):
            answer.append((rows[-1] @ b)[0, 0])
            rows.append(rows[-1] @ a)
            columns.append(a @ columns[-1])
        power = np.linalg.matrix_power(a, values)
        after = scipy.linalg.toeplitz(answer, np.zeros(values))
        power[np.abs(power) < _NOTHING] = 0.0
        return power, np.hstack(columns[::-1]), np.vstack(rows), after

    def density(self, f: Array) -> Array:
        """Return its power at some frequencies, in parts of the rate of values."""
        return np.asarray(np.abs(self._response(np.exp(2j * math.pi * f))) ** 2)

    def _response(self, z: Complex) -> Complex:
        answer = np.full(len(z), complex(self.gain))
        for pole, zero in self.poles:
            for p in {pole, pole.conjugate()}:
                answer *= (z - zero) / (z - p)
        return answer


def _all_pass(pole: complex) -> tuple[Array, Array, Array, float]:
    """Return A, B, C and D of the all-pass section of a pole, or a pair: an orthogonal matrix."""
    s, w = pole.real, pole.imag
    if not w:
        rest = math.sqrt(1.0 - s * s)
        return np.array([[s]]), np.array([[rest]]), np.array([[rest]]), -s
    turning, entry = np.array([[s, w], [-w, s]]), np.array([[1.0], [0.0]])
    root = np.linalg.cholesky(scipy.linalg.solve_discrete_lyapunov(turning, entry @ entry.T))
    a, b = (np.asarray(np.linalg.solve(root, right), dtype=float) for right in (turning @ root, entry))
    row = np.linalg.svd(np.hstack([a, b]))[2][-1]
    return a, b, row[None, :2], float(row[2])


def is_white(values: Array) -> bool:
    """Return whether a series passes for white noise: the mean of its periodogram in each third of an octave.

    Of m lines that is the mean of m exponential variables. All bands together fail once in a
    thousand.
    """
    values = values[:_TESTED]
    lines = np.abs(np.fft.rfft(values - values.mean())[1 : (len(values) + 1) // 2]) ** 2
    if not np.any(lines):
        return True
    edges = np.unique(np.round(_LEAST * 2.0 ** np.arange(0.0, math.log2(max(len(lines) / _LEAST, 2.0)), 1.0 / _BANDS)))
    edges = np.concatenate([[0], edges[edges < len(lines) - _LEAST], [len(lines)]]).astype(np.intp)
    power = np.add.reduceat(lines / lines.mean(), edges[:-1].tolist())
    m = np.diff(edges)
    likely = scipy.special.gammainc(m, power)  # the chance of no more power than that
    return bool(np.all(np.minimum(likely, 1.0 - likely) > 0.5 * _DOUBT / len(m)))


def shaping(values: Array) -> Shaping:
    """Return the filter that makes noise with the spectrum of a series from white noise."""
    segment = min(_LONGEST, 1 << int(math.log2(max(len(values) // _SEGMENTS, _LINES))))
    density = spectrum(values, rate=1.0, segment=segment).density.copy()
    density[:2], density[-1] = density[2], density[-2]  # what the mean leaves, and half a line
    order, low = (min(most, len(density) // _LINES) for most in (_ORDER, _LOW_ORDER))
    stretch = max(1.0, _STRETCH * segment)
    density /= 2.0 * np.var(values)
    poles, gain = _predicted(density, low, (stretch - 1.0) / (stretch + 1.0))
    first = Shaping(gain, poles)
    more, factor = _predicted(density / first.density(np.linspace(0.0, 0.5, len(density))), order, 0.0)
    return Shaping(gain * factor, poles + more)


def _predicted(density: Array, order: int, w: float) -> tuple[tuple[_Pole, ...], float]:
    """Return poles and gain of the all-pole model of a density from zero to half the rate, on a stretched axis."""
    omega = np.linspace(0.0, math.pi, len(density))
    angle = omega + 2.0 * np.arctan2(w * np.sin(omega), 1.0 - w * np.cos(omega))
    weight = np.gradient(angle)
    weight[[0, -1]] *= 0.5
    known = np.cos(np.outer(np.arange(order + 1), angle)) @ (density * weight) / math.pi
    a = np.concatenate([[1.0], -scipy.linalg.solve_toeplitz(known[:-1], known[1:])])
    roots = [complex(root) for root in np.roots(a) if root.imag >= 0.0]
    gain = math.sqrt(float(known @ a))
    for p in roots:
        gain /= abs(1.0 + p * w) ** (2.0 if p.imag else 1.0)
    return tuple(((w + p) / (1.0 + w * p), w) for p in roots), gain
