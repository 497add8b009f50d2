"""The questions of figures to a loop on its frequency axis, and their answers by polynomials that are known exactly."""

import math
from typing import Protocol

import flint
import numpy as np

from proofmass.runner.analysis.linearisation.rational import Transfer, precise, roots
from proofmass.runner.analysis.margins.crossings import (
    Crossing,
    end,
    first_fall,
    gain_crossings,
    largest_ratio,
    phase_crossings,
    rest,
    value_at,
)
from proofmass.runner.host.arrays import Array, Complex

TANGENTIAL = 1e-6  # part of its speed with which a pole must cross the boundary for its direction to be certain


class Axis(Protocol):
    """L on the frequency axis. Angles are those of a period, of a continuous loop angular frequencies."""

    sampled: bool

    def values(self, w: Array) -> Complex:
        """Return L."""
        ...

    def gain_crossings(self) -> list[Crossing]:
        """Return where |L| = 1."""
        ...

    def phase_crossings(self) -> list[Crossing]:
        """Return where L is negative, half the rate included."""
        ...

    def rest(self) -> Crossing | None:
        """Return L at rest, or None if it is infinite there."""
        ...

    def end(self) -> Crossing | None:
        """Return L at the end of the axis, or None if it is infinite there."""
        ...

    def sensitivity(self) -> tuple[float, float]:
        """Return place and value of the largest |S|."""
        ...

    def difference(self) -> tuple[float, float]:
        """Return place and value of the largest |S - T|."""
        ...

    def fall(self) -> float | None:
        """Return the first place at which |T| is 3 dB less than at rest."""
        ...

    def outwards(self, factor: float, w: float) -> float:
        """Return how a pole that a factor puts there moves as the factor grows: 1 straight outwards, -1 inwards."""
        ...

    def outside(self, factor: float) -> int:
        """Return the number of closed-loop poles that are not inside, with a factor that puts none on the boundary."""
        ...


class CertifiedAxis(Axis):
    """Crossovers, peaks and counts as roots of polynomials that certified arithmetic separates."""

    def __init__(self, loop: Transfer, sampled: bool) -> None:
        """Take L in the variable of the state space."""
        self.sampled, self._loop, self._axis = sampled, loop, loop.on_axis(sampled)

    def values(self, w: Array) -> Complex:
        """Return L, at one place after the other."""
        return np.array([value_at(self._axis, math.tan(0.5 * t) if self.sampled else t) for t in w.tolist()])

    def gain_crossings(self) -> list[Crossing]:
        return gain_crossings(self._axis)

    def phase_crossings(self) -> list[Crossing]:
        return phase_crossings(self._axis)

    def rest(self) -> Crossing | None:
        return rest(self._axis)

    def end(self) -> Crossing | None:
        return end(self._axis)

    def sensitivity(self) -> tuple[float, float]:
        return largest_ratio(self._axis, self._axis.denominator, self._axis.closed)

    def difference(self) -> tuple[float, float]:
        return largest_ratio(self._axis, self._axis.denominator - self._axis.numerator, self._axis.closed)

    def fall(self) -> float | None:
        return first_fall(self._axis, self._axis.numerator, self._axis.closed)

    def outwards(self, factor: float, w: float) -> float:
        """Return how a pole z of f N + D moves: by -N / (f N' + D') times the change of f; NaN if it has no speed."""
        precise()
        place = flint.acb.exp(flint.acb(0, w)) if self.sampled else flint.acb(0, w)
        slope = factor * self._loop.numerator.derivative()(place) + self._loop.denominator.derivative()(place)
        if slope == 0:
            return math.nan
        speed = complex(-self._loop.numerator(place) / slope)
        return (speed / complex(place) if self.sampled else speed).real / abs(speed)

    def outside(self, factor: float) -> int:
        """Return the number of closed-loop poles that are not inside."""
        return poles_outside(self._loop, factor, self.sampled)


def poles_outside(loop: Transfer, factor: float, sampled: bool) -> int:
    """Return the number of closed-loop poles that are not inside, from all of them."""
    top, bottom = factor.as_integer_ratio()
    closed = top * loop.numerator + bottom * loop.denominator
    return sum(not (abs(root) < 1 if sampled else root.real < 0) for root in roots(closed, sampled))
