"""Crossovers and peaks on the frequency axis as real roots, proved to be complete.

On the axis s = j t a polynomial is e(y) + j t o(y), y = t^2, so that |N|^2 - |D|^2, the imaginary part of N conj(D) and
the slope of |D|^2 / |N + D|^2 are polynomials in y with integer coefficients. Their positive roots are separated by
certified arithmetic (Arb: Johansson, IEEE Trans. Computers 66, 2017, 1281): none is missed, none invented, however
narrow a resonance or however near to each other two crossovers are.
"""

import math
from dataclasses import dataclass
from typing import Any

import flint

from proofmass.runner.analysis.linearisation.rational import (
    Rational,
    coprime,
    even_and_odd,
    positive_roots,
    precise,
    square,
)
from proofmass.runner.analysis.linearisation.real_roots import Polynomial

_FLAT = 1e-12


@dataclass(frozen=True)
class Crossing:
    """A frequency and L there: its size, and the phase that is left until -1, arg(-L)."""

    w: float  # rad/s, infinite at the end of a continuous loop's axis; of a sampled loop relative to one period: rad
    size: float
    lag: float  # rad, in (-pi, pi]


def gain_crossings(loop: Rational) -> list[Crossing]:
    """Return where |L| = 1, between rest and half the rate.

    A first crossover does not count if |L| is 1 to rounding all the way up to it, as in filters at low frequency.
    """
    difference = square(loop.numerator) - square(loop.denominator)
    roots = positive_roots(difference)
    at_rest = rest(loop)
    if roots and at_rest is not None and abs(at_rest.size - 1.0) < _FLAT:
        largest = max(abs(abs(_value(loop, roots[0].sqrt() * part)) - 1) for part in (0.1, 0.5, 0.9))
        roots = roots[1:] if largest < _FLAT else roots
    return [_crossing(loop, y) for y in roots]


def phase_crossings(loop: Rational) -> list[Crossing]:
    """Return where L is negative, half the rate included."""
    (ne, no), (de, do) = even_and_odd(loop.numerator), even_and_odd(loop.denominator)
    turned = no * de - ne * do
    real = ne * de + flint.fmpz_poly([0, 1]) * no * do
    separate = turned
    if turned.degree() < 0:  # L is real everywhere and crosses the axis nowhere
        separate = flint.fmpz_poly([1])
    while (common := separate.gcd(real)).degree() > 0:  # where L is zero or infinite it has no sign
        separate = separate // common
    found = [_crossing(loop, y) for y in positive_roots(separate) if real(y) < 0]
    last = end(loop)
    return [*found, last] if loop.sampled and last is not None and last.lag == 0.0 else found


def rest(loop: Rational) -> Crossing | None:
    """Return L at rest, or None if it is infinite there."""
    return real_crossing(0.0, loop.numerator[0], loop.denominator[0])


def end(loop: Rational) -> Crossing | None:
    """Return L at the end of the axis: at half the rate, or at infinite frequency; None if it is infinite there."""
    return real_crossing(_end_of(loop), loop.numerator[loop.degree], loop.denominator[loop.degree])


def largest_ratio(loop: Rational, above: Polynomial, below: Polynomial) -> tuple[float, float]:
    """Return frequency and value of the largest |above / below| on the axis, the ends included; infinite at a pole.

    The axis of a continuous loop ends at infinite frequency, where S of a loop that falls off is 1.
    """
    precise()
    top, bottom, _ = coprime(square(above), square(below))
    if poles := positive_roots(bottom):
        return _frequency(loop, poles[0]), math.inf
    slope = top.derivative() * bottom - top * bottom.derivative()
    ends = ((0.0, 0), (_end_of(loop), max(top.degree(), bottom.degree())))
    candidates = [(w, _root_of(int(top[power]), int(bottom[power]))) for w, power in ends]
    candidates += [(_frequency(loop, y), float((top(y) / bottom(y)).sqrt())) for y in positive_roots(slope)]
    return max(candidates, key=lambda pair: pair[1])


def first_fall(loop: Rational, above: Polynomial, below: Polynomial) -> float | None:
    """Return the first frequency at which |above / below| is 3 dB less than at rest."""
    precise()
    at_rest = int(above[0]) ** 2, int(below[0]) ** 2
    if at_rest[0] == 0 or at_rest[1] == 0:
        return None
    difference = 2 * at_rest[1] * square(above) - at_rest[0] * square(below)
    found = positive_roots(difference)
    return _frequency(loop, found[0]) if found else None


def _crossing(loop: Rational, y: Any) -> Crossing:
    value = _value(loop, y.sqrt())
    return Crossing(_frequency(loop, y), float(abs(value)), float((-value).arg()))


def value_at(loop: Rational, t: float) -> complex:
    """L at s = j t."""
    precise()
    return complex(_value(loop, flint.arb(t)))


def _value(loop: Rational, t: Any) -> Any:
    s = flint.acb(0, t)
    return loop.numerator(s) / loop.denominator(s)


def _frequency(loop: Rational, y: Any) -> float:
    t = y.sqrt()
    return float(2 * t.atan()) if loop.sampled else float(t)


def _end_of(loop: Rational) -> float:
    return math.pi if loop.sampled else math.inf


def real_crossing(w: float, top: Any, bottom: Any) -> Crossing | None:
    """Return a crossing at which L is a quotient of integers, or None if it is infinite there."""
    precise()
    if bottom == 0:
        return None
    value = flint.fmpq(top, bottom)
    return Crossing(w, float(abs(flint.arb(value))), 0.0 if value < 0 else math.pi)


def _root_of(top: int, bottom: int) -> float:
    return float(flint.arb(flint.fmpq(top, bottom)).sqrt()) if bottom else math.inf
