"""From the random numbers and the errors of quantisers of a period to the values of an output in it.

    x[n+1] = A x[n] + B w[n],   y[n] = C x[n] + D w[n],   H(z) = C (z - A)^-1 B + D

w holds independent numbers of known variance v, y the r values of the output in a period T. The
mean one-sided density of what repeats its statistics every period is, with z = exp(2 pi j f T) and
up to half the rate of the output,

    S(f) = 2 T / r^2 sum over k of v[k] |sum over i of exp(-2 pi j f i T / r) H[i, k](z)|^2

(Gardner, Cyclostationary Random Processes, 1985, section 12.4). All that sampling, holding and
decimation fold back is in it. Its integral is the mean square of the output, which needs no
integral:

    sum over k of v[k] (B' Q B + D' D / r)[k, k],   Q = A' Q A + C' C / r
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.decisions.one_bit import FILTER
from proofmass.runner.analysis.linearisation.balance import balanced
from proofmass.runner.analysis.linearisation.covariance import in_rms, summed
from proofmass.runner.analysis.linearisation.lasting import Lasting
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.rings import Entry
from proofmass.runner.analysis.linearisation.wire_response import Matrices, SampledStateSpace, WireResponse
from proofmass.runner.derivatives.dual_noise import DEVIATE, ONE_BIT, rounds
from proofmass.runner.derivatives.stepped_ticks import Indices
from proofmass.runner.host.arrays import Array, Complex

_LARGEST = 1 << 21  # complex numbers that are computed at a time
_MARGIN = 1e-12  # distance of the spectral radius below one
_NEUTRAL = 1e-9  # distance above one to which rounding may move a pole on the unit circle


def variance(part: str) -> float:
    """Return the variance of an input: of a deviate, of a uniform error of one step, or zero."""
    return 1.0 if part in (DEVIATE, ONE_BIT) else 1.0 / 12.0 if rounds(part) else 0.0


@dataclass(frozen=True)
class NoiseMap(SampledStateSpace):
    """The map from sources to one output over a period, and from an input where there is one."""

    inputs: tuple[Entry, ...]  # a column each
    slopes: Mapping[str, Matrices]  # derivatives of the matrices by each parameter
    filtered: bool = False  # some of the states are those of filters before the sources

    @property
    def rate(self) -> float:
        """Values of the output a second."""
        return self.values / self.period

    @property
    def sources(self) -> list[Endpoint]:
        """Block and kind of each source."""
        return [source for source in self._columns if variance(source[1])]

    def columns(self, source: Endpoint) -> list[int]:
        """The columns of a source, or of an input."""
        return self._columns.get(source, [])

    @cached_property
    def _columns(self) -> Mapping[Endpoint, list[int]]:
        columns: dict[Endpoint, list[int]] = {}
        for column, entry in enumerate(self.inputs):
            columns.setdefault(entry[:2], []).append(column)
        return columns

    @cached_property
    def variances(self) -> Array:
        """Variance of each column, zero for an input."""
        return np.array([variance(part) for _, part, _ in self.inputs])

    @property
    def settles(self) -> bool:
        """Return whether the mean square of the output has a bound."""
        return self.radius < 1.0 - _MARGIN

    @property
    def grows(self) -> bool:
        """Return whether the output grows without end: a mode is unstable, not only neutral."""
        return self.radius > 1.0 + _NEUTRAL

    @cached_property
    def mean_squares(self) -> Array:
        """Mean square of the output by each source, over all frequencies."""
        _, b, _, d = self.matrices
        q = self.observed
        weight = self.variances * (np.einsum("ik,ij,jk->k", b, q, b) + np.sum(d**2, axis=0) / self.values)
        return np.asarray(np.maximum(weight, 0.0) @ self._members)  # large Q may round so

    @cached_property
    def observed(self) -> Array:
        """Q in Q = A' Q A + C' C / r."""
        a, _, c, _ = self.matrices
        return summed(a.T, c.T @ c / self.values)

    def densities(self, frequencies: Array) -> Array:
        """One-sided density at the output by source: a row for each frequency, in unit^2/Hz."""
        width = max(1, _LARGEST // max(1, len(self.matrices[0]) + len(self.inputs) + self.values))
        parts = (frequencies[i : i + width] for i in range(0, len(frequencies), width))
        by_source = self.variances[:, None] * self._members
        rows = [_squared(self.heard(part)) @ by_source for part in parts]
        return np.vstack(rows) * (2.0 * self.period / self.values**2) if rows else np.zeros((0, len(self.sources)))

    def gain(self, frequencies: Array, source: Endpoint, late: float) -> Complex:
        """Return what comes out at the frequency that goes in at an input, whose first value is so much earlier."""
        a, b, c, d = self.matrices
        columns = self.columns(source)
        return WireResponse((a, b[:, columns], c, d[:, columns]), self.period, late).gain(frequencies)

    def heard(self, frequencies: Array) -> Array:
        """Return the real parts of the shares of columns in the output at frequencies, and below them the imaginary.

        They come from the transposed system, without the whole H. So products with B and D are
        those of real numbers.
        """
        a, b, _, _ = self.matrices
        begins, c, d = self._held_once
        turns = np.exp(-2j * np.pi * np.outer(frequencies, np.arange(self.values)) / self.rate)
        turn: Complex = np.add.reduceat(turns, begins, axis=1)
        direct = np.vstack([turn.real, turn.imag]) @ d
        if not len(a):
            return direct
        z = np.exp(2j * np.pi * frequencies * self.period)
        x = np.zeros((len(a), len(frequencies)), dtype=complex)
        form, scale, basis = self._schur
        known = basis.conj().T @ ((turn @ c).T * scale[:, None])
        for i in range(len(a) - 1, -1, -1):
            x[i] = (known[i] + form[i, i + 1 :] @ x[i + 1 :]) / (z - form[i, i])
        rows = ((basis @ x) / scale[:, None]).T
        direct += np.vstack([rows.real, rows.imag]) @ b
        return np.asarray(direct)

    @cached_property
    def _held_once(self) -> tuple[Indices, Array, Array]:
        """The first of the values that are held alike one after the other, and rows of C and D for these alone."""
        _, _, c, d = self.matrices
        new = (c[1:] != c[:-1]).any(axis=1) | (d[1:] != d[:-1]).any(axis=1)
        begins = np.flatnonzero(np.append(True, new))
        return begins, c[begins], d[begins]

    @cached_property
    def _schur(self) -> tuple[Complex, Array, Complex]:
        """Schur form of the transposed A, in units of the states that make it alike."""
        a, b, c, _ = self.matrices
        alike, scale = in_rms(a, b * np.sqrt(self.variances)) if self.filtered else balanced(a, b, c)
        form, basis, *_ = scipy.linalg.schur(alike.T, output="complex")
        return np.asarray(form), np.asarray(scale), np.asarray(basis)

    @cached_property
    def _members(self) -> Array:
        """A column for each source, with one where a column of the map is its own."""
        members = np.zeros((len(self.inputs), len(self.sources)))
        for number, source in enumerate(self.sources):
            members[self.columns(source), number] = 1.0
        return members


def _squared(halves: Array) -> Array:
    """Return the squares of complex numbers, by their real parts and the imaginary ones below."""
    np.square(halves, out=halves)
    real, imaginary = np.split(halves, 2)
    real += imaginary
    return np.asarray(real)


def noise_map(whole: PeriodMap, output: Endpoint) -> NoiseMap:
    """The map to one output, without what does not reach it and without modes that do not show."""
    to_output = whole.to_outputs([i for i, entry in enumerate(whole.outputs) if entry[:2] == output]).between()
    a, b, c, d = to_output.parts()
    lasting = Lasting(a, b * np.sqrt([variance(name) for _, name, _ in to_output.inputs]))
    identity = np.eye(len(a))
    left, right = (identity, identity) if lasting.passes(b, c) else lasting.reduction
    slopes = {name: _reduced(to_output.parts(slope), left, right) for name, slope in to_output.slopes.items()}
    reduced = _reduced((a, b, c, d), left, right)
    filtered = any(part.startswith(FILTER) for _, part, _ in to_output.states)
    return NoiseMap(reduced, to_output.period, to_output.inputs, slopes, filtered)


def _reduced(parts: Matrices, left: Array, right: Array) -> Matrices:
    a, b, c, d = parts
    return left @ a @ right, left @ b, c @ right, d
