"""Crossovers and peaks on the frequency axis as real roots, proved to be complete.

On the axis s = j t a polynomial is e(y) + j t o(y), y = t^2, so that |N|^2 - |D|^2, the imaginary
part of N conj(D) and the slope of |D|^2 / |N + D|^2 are polynomials in y with integer coefficients.
Their positive roots are separated by certified arithmetic (Arb: Johansson, IEEE Trans. Computers
66, 2017, 1281): none is missed, none invented, however narrow a resonance or however near to each
other two crossovers are.
"""

import math
from dataclasses import dataclass
from typing import Any

import flint
import numpy as np

from proofmass.runner.analysis.linearisation.rational import (
    Transfer,
    coprime,
    even_and_odd,
    positive_roots,
    roots,
    square,
)
from proofmass.runner.analysis.linearisation.real_roots import Polynomial
from proofmass.runner.host.arrays import Array, Complex
from proofmass.runner.host.precision import precision

TANGENTIAL = 1e-6  # part of its speed with which a pole must cross the boundary for its direction to be certain
AT_REST = 1e-9  # of the largest |T|: one at rest that is rounding
_LITTLE = 1e-3  # |T| at rest that may be rounding
_FLAT = 1e-12


@dataclass(frozen=True)
class Crossing:
    """A frequency and L there: its size, and the phase that is left until -1, arg(-L)."""

    w: float  # rad/s, infinite at the end of a continuous loop's axis; of a sampled loop relative to one period: rad
    size: float
    lag: float  # rad, in (-pi, pi]


class CertifiedAxis:
    """L on the frequency axis. Angles of a period, or angular frequencies."""

    def __init__(self, loop: Transfer, sampled: bool) -> None:
        """Take L in the variable of the state space."""
        self.sampled, self._loop, self._axis = sampled, loop, loop.on_axis(sampled)

    @precision()
    def values(self, w: Array) -> Complex:
        """Return L, at one place after the other."""
        return np.array([complex(self._value(flint.arb(math.tan(0.5 * t) if self.sampled else t))) for t in w.tolist()])

    @precision()
    def gain_crossings(self) -> list[Crossing]:
        """Return where |L| = 1, between rest and half the rate.

        A first crossover does not count if |L| is 1 to rounding all the way up to it, as in filters
        at low frequency.
        """
        found = positive_roots(square(self._axis.numerator) - square(self._axis.denominator))
        at_rest = self.rest()
        if found and at_rest is not None and abs(at_rest.size - 1.0) < _FLAT:
            largest = max(abs(abs(self._value(found[0].sqrt() * part)) - 1) for part in (0.1, 0.5, 0.9))
            found = found[1:] if largest < _FLAT else found
        return [self._crossing(y) for y in found]

    @precision()
    def phase_crossings(self) -> list[Crossing]:
        """Return where L is negative, half the rate included."""
        (ne, no), (de, do) = even_and_odd(self._axis.numerator), even_and_odd(self._axis.denominator)
        turned = no * de - ne * do
        real = ne * de + flint.fmpz_poly([0, 1]) * no * do
        separate = turned
        if turned.degree() < 0:  # L is real everywhere and crosses the axis nowhere
            separate = flint.fmpz_poly([1])
        while (common := separate.gcd(real)).degree() > 0:  # zero or infinite L has no sign
            separate = separate // common
        found = [self._crossing(y) for y in positive_roots(separate) if real(y) < 0]
        last = self.end()
        return [*found, last] if self.sampled and last is not None and last.lag == 0.0 else found

    def rest(self) -> Crossing | None:
        """Return L at rest, or None if it is infinite there."""
        return real_crossing(0.0, self._axis.numerator[0], self._axis.denominator[0])

    def end(self) -> Crossing | None:
        """Return L at the end of the axis: at half the rate, or at infinite frequency; None if it is infinite there."""
        last = self._loop.degree
        return real_crossing(self._last, self._axis.numerator[last], self._axis.denominator[last])

    def largest(self, part: int) -> tuple[float, float]:
        """Return place and value of the largest |S - part T|."""
        return self.largest_ratio(self._axis.denominator - part * self._axis.numerator, self._axis.closed)

    @precision()
    def largest_ratio(self, above: Polynomial, below: Polynomial) -> tuple[float, float]:
        """Return place and value of the largest |above / below| on the axis, the ends included;
        infinite at a pole.

        The axis of a continuous loop ends at infinite frequency, where S of a loop that falls off
        is 1.
        """
        top, bottom, _ = coprime(square(above), square(below))
        if poles := positive_roots(bottom):
            return self._frequency(poles[0]), math.inf
        slope = top.derivative() * bottom - top * bottom.derivative()
        ends = ((0.0, 0), (self._last, max(top.degree(), bottom.degree())))
        candidates = [(w, _root_of(int(top[power]), int(bottom[power]))) for w, power in ends]
        candidates += [(self._frequency(y), float((top(y) / bottom(y)).sqrt())) for y in positive_roots(slope)]
        return max(candidates, key=lambda pair: pair[1])

    @precision()
    def fall(self) -> float | None:
        """Return the first place at which |T| is 3 dB less than at rest; None where it is zero there, to rounding."""
        above, below = self._axis.numerator, self._axis.closed
        at_rest = int(above[0]) ** 2, int(below[0]) ** 2
        if at_rest[0] == 0 or at_rest[1] == 0:
            return None
        size = _root_of(*at_rest)
        if size < _LITTLE and size <= AT_REST * self.largest_ratio(above, below)[1]:
            return None
        found = positive_roots(2 * at_rest[1] * square(above) - at_rest[0] * square(below))
        return self._frequency(found[0]) if found else None

    @precision()
    def outwards(self, factor: float, w: float) -> float:
        """Return how a pole that a factor puts there moves as the factor grows: 1 straight outwards, -1 inwards.

        A pole z of f N + D moves by -N / (f N' + D') times the change of f; NaN if it has no speed.
        """
        place = flint.acb.exp(flint.acb(0, w)) if self.sampled else flint.acb(0, w)
        slope = factor * self._loop.numerator.derivative()(place) + self._loop.denominator.derivative()(place)
        if slope == 0:
            return math.nan
        speed = complex(-self._loop.numerator(place) / slope)
        return (speed / complex(place) if self.sampled else speed).real / abs(speed)

    @precision()
    def outside(self, factor: float) -> int:
        """Return the number of closed-loop poles that are not inside, with a factor that puts none on the boundary."""
        top, bottom = factor.as_integer_ratio()
        closed = top * self._loop.numerator + bottom * self._loop.denominator
        return sum(not (abs(z) < 1 if self.sampled else z.real < 0) for z in roots(closed, self.sampled))

    def _crossing(self, y: Any) -> Crossing:
        value = self._value(y.sqrt())
        return Crossing(self._frequency(y), float(abs(value)), float((-value).arg()))

    def _value(self, t: Any) -> Any:
        """L at s = j t."""
        s = flint.acb(0, t)
        return self._axis.numerator(s) / self._axis.denominator(s)

    def _frequency(self, y: Any) -> float:
        t = y.sqrt()
        return float(2 * t.atan()) if self.sampled else float(t)

    @property
    def _last(self) -> float:
        return math.pi if self.sampled else math.inf


@precision()
def real_crossing(w: float, top: Any, bottom: Any) -> Crossing | None:
    """Return a crossing at which L is a quotient of integers, or None if it is infinite there."""
    if bottom == 0:
        return None
    value = flint.fmpq(top, bottom)
    return Crossing(w, float(abs(flint.arb(value))), 0.0 if value < 0 else math.pi)


def _root_of(top: int, bottom: int) -> float:
    return float(flint.arb(flint.fmpq(top, bottom)).sqrt()) if bottom else math.inf
