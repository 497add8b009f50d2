"""The positive real roots of polynomials with integer coefficients, each alone in a ball.

By Descartes' rule of signs a polynomial has at most as many positive roots as its coefficients
change signs, and just as many with no change or one. An interval in which there may be more is cut
in two (Collins and Akritas, SYMSAC 1976, 272), between powers of two first. Roots elsewhere cost
nothing, as the cluster at -1 that delays leave on the axis of a sampled loop. Newton's method makes
roots precise, and a change of sign proves them.
"""

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import flint

from proofmass.runner.host.precision import precision

Polynomial = Any  # flint.fmpz_poly
Fraction = Any  # flint.fmpq
_FIRST_BITS = 128  # of arithmetic; it is doubled where they do not tell the sign


def zeros(polynomial: Polynomial) -> int:
    """Return how often a polynomial has the root 0."""
    return next((k for k, value in enumerate(polynomial.coeffs()) if value != 0), 0)


@precision()
def isolated(polynomial: Polynomial, bits: int) -> list[Any]:
    """Return the distinct positive roots, smallest first, as balls with about so many bits."""
    if not _changes(polynomial):
        return []
    simple = polynomial // polynomial.gcd(polynomial.derivative())
    return [_precise(simple, low, high, bits) for low, high in sorted(_separated(simple))]


def _separated(simple: Polynomial) -> Iterator[tuple[Fraction, Fraction]]:
    """Yield intervals that hold one root each, or have it as both ends."""
    coefficients = list(map(int, simple.coeffs()[zeros(simple) :]))
    last, first = _octaves(coefficients[::-1]), -_octaves(coefficients)
    left = [(_power(first), _power(last))]
    while left:
        low, high = left.pop()
        changes = _changes_between(simple, low, high)
        if changes == 1:
            yield low, high
        elif changes:
            middle = _between(low, high)
            left += [(low, middle), (middle, high)]
            if simple(middle) == 0:
                simple = simple // _factor(middle)
                yield middle, middle


def _octaves(coefficients: list[int]) -> int:
    """Return a power of two beyond the inverses of all roots: twice Fujiwara's bound."""
    first = abs(coefficients[0]).bit_length() - 1
    sizes = ((abs(value).bit_length() - first, i) for i, value in enumerate(coefficients) if i and value)
    return 2 + max((-(-size // i) for size, i in sizes), default=0)


def _power(exponent: int) -> Fraction:
    return flint.fmpq(1 << exponent) if exponent >= 0 else flint.fmpq(1, 1 << -exponent)


def _between(low: Fraction, high: Fraction) -> Fraction:
    """Return a power of two between two that are apart, else the middle."""
    ratio = high / low
    if ratio < 4:
        return (low + high) / 2
    return low * _power((int(ratio.p).bit_length() - int(ratio.q).bit_length()) // 2)


def _changes(polynomial: Polynomial) -> int:
    """Return how often the coefficients change signs."""
    signs = [value > 0 for value in map(int, polynomial.coeffs()) if value]
    return sum(one != other for one, other in pairwise(signs))


def _changes_between(polynomial: Polynomial, low: Fraction, high: Fraction) -> int:
    """Return a bound of the number of roots in an open interval, which is right if it is 0 or 1."""
    unit = int(low.q if low.q > high.q else high.q)  # a power of two
    first, width = int(low * unit), int((high - low) * unit)
    n, bits = polynomial.degree(), unit.bit_length() - 1
    scaled = flint.fmpz_poly([int(value) << (bits * (n - i)) for i, value in enumerate(polynomial.coeffs())])
    moved = scaled(flint.fmpz_poly([first, width])).coeffs()
    moved += [0] * (n + 1 - len(moved))
    return _changes(flint.fmpz_poly(moved[::-1])(flint.fmpz_poly([1, 1])))


def _precise(polynomial: Polynomial, low: Fraction, high: Fraction, bits: int) -> Any:
    """Return the only root between two fractions, or at both, as a ball."""
    if low == high:
        flint.ctx.prec = bits
        return flint.arb(low)
    for end in (low, high):
        if polynomial(end) == 0:
            polynomial = polynomial // _factor(end)
    rising, slope = polynomial(high) > 0, polynomial.derivative()
    flint.ctx.prec = _FIRST_BITS + max(int(part).bit_length() for end in (low, high) for part in (end.p, end.q))
    low, high = flint.arb(low), flint.arb(high)
    place, last = ((low + high) / 2).mid(), high - low
    while True:
        value = polynomial(place)
        step = (place - value / slope(place)).mid()
        if value.contains(0) or abs(step - place) < place * _power(-bits):
            ball = flint.arb(step, (step * _power(1 - bits)).upper())
            enough = flint.ctx.prec >= bits + _FIRST_BITS  # to tell the ball's ends apart
            if enough and polynomial(ball.lower()) * polynomial(ball.upper()) < 0:
                return ball
            flint.ctx.prec *= 2
            place, last = step if low < step < high else place, high - low  # with more bits it goes on from there
            continue
        low, high = (low, place) if (value > 0) == rising else (place, high)
        by_newton = low < step < high and 2 * abs(step - place) < last
        last = abs(step - place) if by_newton else high - low
        place = step if by_newton else ((low + high) / 2).mid()


def _factor(root: Fraction) -> Polynomial:
    return flint.fmpz_poly([-int(root.p), int(root.q)])
