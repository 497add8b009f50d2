"""The scalar open loop as an exact quotient of polynomials, L = N / D, from the numbers of its state space.

A double is a fraction with a power of two below, so that N and D are known exactly:

    D(z) = det(z - A),   N(z) = det(z - A + B C) - (1 - d) D(z).

Sampled loops are turned onto the axis s = j t by z = (1 + s) / (1 - s), t = tan(w T / 2), as in
Franklin, Powell and Workman, Digital Control of Dynamic Systems, 6.3, so that the rest is written
once, for both kinds of loops. The integers have thousands of bits; FLINT (flintlib.org) does their
arithmetic.
"""

import math
from dataclasses import dataclass
from typing import Any

import flint
import numpy as np

from proofmass.runner.analysis.linearisation.balance import balanced
from proofmass.runner.analysis.linearisation.elimination import eliminated, fraction
from proofmass.runner.analysis.linearisation.many_roots import many_roots
from proofmass.runner.analysis.linearisation.real_roots import Polynomial, isolated
from proofmass.runner.host.arrays import Array
from proofmass.runner.host.precision import BITS, precision

LARGEST_ORDER = 160  # of systems whose polynomials are those of dense matrices
LARGEST_CERTIFIED = 64  # degree of polynomials whose roots are separated by certified arithmetic


@dataclass(frozen=True)
class Transfer:
    """N / D in the variable of the state space: z of a sampled loop, s of a continuous one."""

    numerator: Polynomial
    denominator: Polynomial

    @property
    def closed(self) -> Polynomial:
        """N + D, whose zeros are the closed-loop poles."""
        return self.numerator + self.denominator

    @property
    def degree(self) -> int:
        """The larger of both degrees."""
        return max(int(self.numerator.degree()), int(self.denominator.degree()), 0)

    def on_axis(self, sampled: bool) -> "Transfer":
        """Return the quotient on the frequency axis, of the same degree; z = -1 of a sampled loop is at infinity."""
        parts = self.numerator, self.denominator
        return Transfer(*(_turned(part, self.degree) for part in parts)) if sampled else self


def transfer(a: Array, b: Array, c: Array, d: float) -> Transfer | None:
    """Return the quotient of a single input and output; common factors stay in it.

    None where more states are left than `LARGEST_ORDER` once those are taken out that only pass on
    what they get.
    """
    n = len(a)
    a, b, c = _scaled(a, b.reshape(n), c.reshape(n))
    sparse = eliminated(a, b, c, d)
    if sparse is not None:
        return _over_integers(*(flint.fmpq_poly(_backwards(part.coeffs(), n)) for part in sparse))  # in z, not 1 / z
    if n > LARGEST_ORDER:
        return None
    matrix, column, row = map(_fractions, (a, b.reshape(n, 1), c.reshape(1, n)))
    below = matrix.charpoly()
    return _over_integers((matrix - column * row).charpoly() - below + fraction(d) * below, below)


def _over_integers(numerator: Any, denominator: Any) -> Transfer:
    """Return the quotient of polynomials with fractions as coefficients, by integers without a common factor."""
    unit = math.lcm(int(numerator.denom()), int(denominator.denom()))
    parts = [(part * unit).numer() for part in (numerator, denominator)]
    content = max(math.gcd(*(int(part.content()) for part in parts)), 1)
    return Transfer(*(flint.fmpz_poly([value // content for value in part.coeffs()]) for part in parts))


def characteristic(a: Array) -> Polynomial:
    """Return det(z - A) up to a power of two."""
    return _fractions(_scaled(a, np.zeros(len(a)), np.zeros(len(a)))[0]).charpoly().numer()


def even_and_odd(polynomial: Polynomial) -> tuple[Polynomial, Polynomial]:
    """Return e and o in p(j t) = e(t^2) + j t o(t^2)."""
    coefficients = polynomial.coeffs()
    parts = [flint.fmpz_poly([value * (-1) ** i for i, value in enumerate(coefficients[start::2])]) for start in (0, 1)]
    return parts[0], parts[1]


def square(polynomial: Polynomial) -> Polynomial:
    """Return |p(j t)|^2 as a polynomial in t^2."""
    even, odd = even_and_odd(polynomial)
    return even * even + odd * odd * flint.fmpz_poly([0, 1])


@precision()
def positive_roots(polynomial: Polynomial) -> list[Any]:
    """Return the distinct real roots above zero, smallest first, as balls of one root each."""
    return isolated(polynomial, BITS) if polynomial.degree() > 0 else []


@precision()
def roots(polynomial: Polynomial, sampled: bool = False) -> list[Any]:
    """Return all roots with their multiplicity, as balls that hold them.

    Those of a `sampled` loop of many states are sharp enough to lie on one side of the unit circle,
    if they do.
    """
    if polynomial.degree() < 1:
        return []
    if sampled and polynomial.degree() > LARGEST_CERTIFIED:
        balls = many_roots(polynomial, BITS)
        if balls is not None:
            return balls
    return [root for root, times in polynomial.complex_roots() for _ in range(times)]


def coprime(first: Polynomial, second: Polynomial) -> tuple[Polynomial, Polynomial, Polynomial]:
    """Return both without their common factor, and that factor."""
    common = first.gcd(second)
    if common.degree() < 1:
        return first, second, flint.fmpz_poly([1])
    return first // common, second // common, common


def _scaled(a: Array, b: Array, c: Array) -> tuple[Array, Array, Array]:
    """Return the system with states scaled by powers of two: the result keeps its bits, and integers stay short."""
    if len(a) < 2:
        return a, b, c
    alike, scale = balanced(a)
    into, out = b / scale, c * scale
    same = (alike != 0.0).sum() == (a != 0.0).sum() and np.array_equal(into * scale, b)
    return (alike, into, out) if same and np.array_equal(out / scale, c) else (a, b, c)


def _fractions(matrix: Array) -> Any:
    rows, columns = matrix.shape
    return flint.fmpq_mat(rows, columns, [fraction(value) for value in matrix.ravel().tolist()])


def _turned(polynomial: Polynomial, degree: int) -> Polynomial:
    """(1 - s)^degree p((1 + s) / (1 - s)), by z = 2 / (1 - s) - 1."""
    powers = [value * 2**k for k, value in enumerate(polynomial(flint.fmpz_poly([-1, 1])).coeffs())]
    return flint.fmpz_poly(_backwards(powers, degree))(flint.fmpz_poly([1, -1]))


def _backwards(coefficients: list[Any], degree: int) -> list[Any]:
    """Return the coefficients of z^degree p(1 / z)."""
    return [*[0] * (degree + 1 - len(coefficients)), *coefficients[::-1]]
