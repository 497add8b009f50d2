"""From the values of one wire to those of another: frequency response, and frequencies at which to show it.

A period T has p values of the input and r of the output. H is the matrix of the lifted map; the
response at the input's own frequency f is what a network analyser measures, with z = exp(2 pi j f
T):

    G(f) = 1 / r sum over i, k of exp(-2 pi j f (late + i T / r)) H[i, k](z) exp(2 pi j f k T / p)

where the first value of the output is `late` behind that of the input, by clock offsets.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self, TypeAlias

import numpy as np

from proofmass.runner.analysis.linearisation.lasting import Lasting
from proofmass.runner.analysis.linearisation.open_loop import TransferMatrix
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.poles import parts_of
from proofmass.runner.host.arrays import Array, Complex

Matrices: TypeAlias = tuple[Array, Array, Array, Array]
_PER_DECADE = 60
_ABOUT_A_RESONANCE = np.array([-8.0, -4.0, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 4.0, 8.0])  # half widths
_MOST_RESONANCES = 50
_AT_A_TIME = 1_000_000  # values of a wire at some frequencies that are held at a time


@dataclass(frozen=True)
class SampledStateSpace:
    """A, B, C and D of a map over a period, x[n+1] = A x[n] + B u[n], and the period in seconds."""

    matrices: Matrices
    period: float

    @cached_property
    def poles(self) -> Complex:
        """Poles over a period: those of the sets of states that act on each other."""
        a = self.matrices[0]
        found = [np.linalg.eigvals(a[np.ix_(part, part)]) for part in parts_of(a)]
        return np.concatenate([np.zeros(0), *found]).astype(complex)

    @property
    def radius(self) -> float:
        """Size of the slowest pole; below 1 the output settles."""
        return float(np.max(np.abs(self.poles), initial=0.0))

    @property
    def values(self) -> int:
        """Values of the output in a period."""
        return len(self.matrices[3])


@dataclass(frozen=True)
class WireResponse(SampledStateSpace):
    """The map from one wire to another over a period."""

    late: float = 0.0  # s

    @classmethod
    def of(cls, whole: PeriodMap) -> Self:
        """Return the response of a map of one input and one output, without hidden modes."""
        between = whole.between()
        a, b, c, d = between.parts()
        lasting = Lasting(a)
        if not lasting.passes(b, c):
            a, b, c = lasting.without(a, b, c)
        return cls((a, b, c, d), between.period, between.late)

    @property
    def entries(self) -> int:
        """Values of the input in a period."""
        return int(self.matrices[3].shape[1])

    @property
    def top(self) -> float:
        """Half the lower of the two rates, in Hz."""
        return 0.5 * min(self.values, self.entries) / self.period

    def lifted(self, frequencies: Array) -> Complex:
        """H: a matrix for each frequency."""
        return self._transfer(np.asarray(np.exp(2j * np.pi * frequencies * self.period), dtype=complex))

    def gain(self, frequencies: Array) -> Complex:
        """G: what comes out at the frequency that goes in; of few frequencies at a time, where values are many."""
        count = max(1, len(frequencies) * max(self.values, self.entries) // _AT_A_TIME)
        parts = (
            self._transfer.weighted(np.exp(2j * np.pi * some * self.period), *self.turns(some)) / self.values
            for some in np.array_split(np.asarray(frequencies, dtype=np.float64), count)
        )
        return np.concatenate(list(parts))

    def turns(self, frequencies: Array) -> tuple[Complex, Complex]:
        """Weights of the values of the output in a period, and what a sine at a frequency is at those of the input."""
        signs = ((self.values, -2j), (self.entries, 2j))
        out, into = (np.exp(sign * np.pi * np.outer(frequencies, np.arange(n)) * self.period / n) for n, sign in signs)
        late = np.exp(-2j * np.pi * np.asarray(frequencies) * self.late)
        return out * late[:, None], into

    @cached_property
    def _transfer(self) -> TransferMatrix:
        return TransferMatrix(*self.matrices)


def resonances(of: SampledStateSpace) -> list[tuple[float, float]]:
    """Frequency and half width of the poles, folded up to half the rate of the output."""
    top, pairs = 0.5 * of.values / of.period, []
    for pole in of.poles:
        if abs(pole) < 1e-3:
            continue
        frequency = abs(float(np.angle(pole))) / (2.0 * np.pi * of.period)
        width = max(abs(float(np.log(np.abs(pole)))), 1e-9) / (2.0 * np.pi * of.period)
        for turn in range(of.values // 2 + 1):
            pairs += [(abs(turn / of.period + side * frequency), width) for side in (1.0, -1.0)]
    return sorted({(f, w) for f, w in pairs if f <= top})


def grid(of: SampledStateSpace, low: float, high: float, more: Sequence[float] = ()) -> Array:
    """Frequencies to show a response or a density at: even on a logarithmic axis, and denser about resonances."""
    count = max(2, int(_PER_DECADE * np.log10(high / low)) + 1)
    points = [np.geomspace(low, high, count), np.asarray(more, dtype=float)]
    sharp = [(f, w) for f, w in resonances(of) if f > 0.0 and w < 0.1 * f][:_MOST_RESONANCES]
    points += [f + w * _ABOUT_A_RESONANCE for f, w in sharp]
    every = np.unique(np.concatenate(points))
    return np.asarray(every[(every >= low) & (every <= high)])
