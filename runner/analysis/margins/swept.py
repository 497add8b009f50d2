"""Crossovers and peaks of a sampled loop of many states, between the frequencies of a grid.

L = N / D is known exactly, and so are its poles and those of the closed loop. The grid has so many
points for each turn of a delay, and more around each pole that is sharper than that. Between two
points of it L does not turn far, so that a crossover changes a sign there, or a dip that is looked
at. L is as exact as rounding lets it be, also where the poles of a slow loop lie close to 1
(`OnCircle`).
"""

import cmath
import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from proofmass.runner.analysis.linearisation.on_circle import OnCircle
from proofmass.runner.analysis.linearisation.rational import Transfer, roots
from proofmass.runner.analysis.linearisation.real_roots import zeros
from proofmass.runner.analysis.margins.axis import CertifiedAxis, Crossing, real_crossing
from proofmass.runner.analysis.margins.frequencies import (
    ABOUT_A_POLE,
    Samples,
    crossings,
    highest,
    in_order,
)
from proofmass.runner.host.arrays import Array, Complex

_A_TURN = 16  # points of the grid in each turn of the longest delay
_A_DECADE = 60
_LEAST = 1e-7  # of the angle of the slowest pole, from which the grid begins
_BEFORE_THE_END = 60  # points after the last step
_SHARP = 4.0  # points of the grid, within which the width of a pole gets points of its own
_FLAT = 1e-9  # distance of |L| from 1 at rest within which it counts as 1 there
_ON_POLE = 1e-12  # distance from a pole, of its angle, within which L has no value
_ALL = 1 << 30
_HALVED, _WIDE = 40, 1.0  # how often steps are halved in which f N + D turns further, in radians


class SweptAxis:
    """L of a sampled loop on the unit circle, over the angle of a period."""

    sampled = True

    def __init__(self, loop: Transfer, poles: Sequence[complex]) -> None:
        """Take L in z, and all poles of the closed loop."""
        self._loop, self._poles = loop, np.array(poles, dtype=complex)
        self._circle = OnCircle(loop)
        self._degree = loop.degree - zeros(loop.denominator)  # of f N + D in `_closed`

    def values(self, w: Array) -> Complex:
        """Return L at angles."""
        return self._circle.values(w)

    def gain_crossings(self) -> list[Crossing]:
        """Return where |L| = 1, between rest and half the rate."""
        found = crossings(self._samples, lambda values: np.abs(values) - 1.0, _ALL)
        at_rest = self.rest()
        if found and at_rest is not None and abs(at_rest.size - 1.0) < _FLAT:
            between = np.array([0.1, 0.5, 0.9]) * found[0]
            found = found[1:] if np.max(np.abs(np.abs(self.values(between)) - 1.0)) < _FLAT else found
        return self._crossings(found)

    def phase_crossings(self) -> list[Crossing]:
        below = self._samples.up_to(math.pi * (1.0 - 1e-12))
        found = [c for c in self._crossings(crossings(below, lambda values: values.imag, _ALL)) if abs(c.lag) < 1.0]
        last = self.end()
        return [*(Crossing(c.w, c.size, 0.0) for c in found), *([last] if last and last.lag == 0.0 else [])]

    def rest(self) -> Crossing | None:
        return real_crossing(0.0, self._loop.numerator(1), self._loop.denominator(1))

    def end(self) -> Crossing | None:
        """Return L at half the rate, or None if it is infinite there."""
        return real_crossing(math.pi, self._loop.numerator(-1), self._loop.denominator(-1))

    def largest(self, part: int) -> tuple[float, float]:
        """Return frequency and value of the largest |S - part T|."""

        def measure(values: Complex) -> Array:
            return np.asarray(np.abs((1.0 - part * values) / (1.0 + values)))

        ends = [end for end in (self.rest(), self.end()) if end is not None]
        values = np.array([-end.size if end.lag == 0.0 else end.size for end in ends], dtype=complex)
        with np.errstate(divide="ignore"):
            pairs = zip([end.w for end in ends], measure(values).tolist(), strict=True)
        return max([*pairs, highest(self._samples, measure)], key=lambda pair: pair[1])

    def fall(self) -> float | None:
        """Return the first frequency at which |T| is 3 dB less than at rest."""
        rest = self.rest()
        value = 1.0 if rest is None else rest.size if rest.lag else -rest.size
        at_rest = 1.0 if rest is None else abs(value / (1.0 + value)) if value != -1.0 else math.inf
        if at_rest == 0.0 or math.isinf(at_rest):
            return None
        limit = at_rest * math.sqrt(0.5)
        found = crossings(self._samples, lambda values: np.abs(values / (1.0 + values)) - limit, 1)
        return found[0] if found else None

    def outwards(self, factor: float, w: float) -> float:
        """Return how a pole exp(j w) moves, which turns by dw = -L / L'(w) df / f; L is -1 / factor there."""
        slope = self._circle.turning(w)
        return (1.0 / slope).imag * abs(slope) if slope else math.nan

    def outside(self, factor: float) -> int:
        """Return the number of poles that are not inside, by the turns of f N + D as z goes around the circle."""
        w = np.array([*self._samples.w])
        values = self._closed(w, factor)
        for _ in range(_HALVED):
            turns = np.angle(values[1:] / values[:-1])
            wide = np.flatnonzero(~(np.abs(turns) < _WIDE))
            if not len(wide):
                around = float(np.sum(turns)) / math.pi
                return int(self._degree) - round(around)
            between = 0.5 * (w[wide] + w[wide + 1])
            w = np.insert(w, wide + 1, between)
            values = np.insert(values, wide + 1, self._closed(between, factor))
        return CertifiedAxis(self._loop, True).outside(factor)

    def _closed(self, w: Array, factor: float) -> Complex:
        """Return (f N + D) / (z^k |D|), k being how often D has the root 0."""
        values, turns = self._circle.values_and_turns(w)
        return np.asarray((1.0 + factor * values) * turns)

    def _crossings(self, found: Sequence[float]) -> list[Crossing]:
        values = self.values(np.array(found)).tolist()
        return [Crossing(w, abs(value), cmath.phase(-value)) for w, value in zip(found, values, strict=True)]

    @cached_property
    def _samples(self) -> Samples:
        return Samples.on(self._grid(), self.values)

    def _grid(self) -> Array:
        """Angles up to half a turn, close to each other where L or the closed loop turns fast."""
        open_poles = [complex(root) for root in roots(self._loop.denominator, True)]
        poles = np.concatenate([open_poles, self._poles])
        logs: Complex = np.asarray(np.log(poles[np.abs(poles) > 1e-3]), dtype=np.complex128)
        corners = np.abs(logs)[np.abs(logs) > 1e-12]
        lowest = _LEAST * min(float(np.min(corners, initial=math.pi)), math.pi)
        turns = 0.5 * (len(poles) + 16)
        step = 2.0 * math.pi / (_A_TURN * turns)
        points = [
            np.geomspace(lowest, math.pi, 2 + int(_A_DECADE * math.log10(math.pi / lowest))),
            np.arange(step, math.pi, step),
            math.pi - np.geomspace(1e-9, step, _BEFORE_THE_END),
        ]
        for log in logs[np.abs(logs.real) < _SHARP * step]:
            points.append(log.imag + max(abs(log.real), 1e-9 * abs(log)) * ABOUT_A_POLE)
        on_circle = logs[np.abs(logs.real) < 1e-9 * np.abs(logs)].imag
        return in_order(points, lowest, math.pi, on_circle, _ON_POLE)
