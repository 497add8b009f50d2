"""An exact quotient N / D on the unit circle, to rounding: also next to its poles and where those
lie close to 1.

Polynomials of a moderate degree are products: z less a root has all its digits, since both are
known less 1. Those of long filters, which have many zeros, are sums of powers of z, or of z - 1
next to 1 (`PolynomialValues`).
"""

import math

import flint
import numpy as np

from proofmass.runner.analysis.linearisation.many_roots import PolynomialValues
from proofmass.runner.analysis.linearisation.rational import LARGEST_CERTIFIED, Transfer, roots
from proofmass.runner.analysis.linearisation.real_roots import Polynomial, zeros
from proofmass.runner.host.arrays import Array, Complex
from proofmass.runner.host.precision import precision


class OnCircle:
    """L = N / D = z^-late N' / D', neither of N' and D' with the root 0."""

    def __init__(self, loop: Transfer) -> None:
        """Take a quotient in z."""
        self._above, self._below = _part(loop.numerator), _part(loop.denominator)
        self._late = zeros(loop.denominator) - zeros(loop.numerator)

    def values(self, w: Array) -> Complex:
        """Return L at angles."""
        return self.values_and_turns(w)[0]

    def values_and_turns(self, w: Array) -> tuple[Complex, Complex]:
        """Return L, and D' over its size, at angles."""
        less_one = 2j * np.sin(0.5 * w) * np.exp(0.5j * w)
        with np.errstate(divide="ignore", invalid="ignore"):
            above, below = self._above.logarithm(w, less_one), self._below.logarithm(w, less_one)
            values = np.exp(above - below - 1j * w * self._late)
        return np.asarray(values), np.exp(1j * below.imag)

    def turning(self, w: float) -> complex:
        """Return the derivative of the logarithm of L by the angle."""
        z = complex(math.cos(w), math.sin(w))
        less_one = 2j * math.sin(0.5 * w) * complex(math.cos(0.5 * w), math.sin(0.5 * w))
        return 1j * (z * (self._above.slope(less_one) - self._below.slope(less_one)) - self._late)


class _Product:
    """A polynomial by its roots: its logarithm at angles, of which z - 1 is given too, and p' / p at a place."""

    @precision()
    def __init__(self, polynomial: Polynomial) -> None:
        self._roots = np.array([complex(root - 1) for root in roots(polynomial)], dtype=complex)
        lead = flint.arb(polynomial[max(polynomial.degree(), 0)])
        self._lead = complex(float(abs(lead).log()), math.pi if lead < 0 else 0.0) if lead != 0 else complex(-math.inf)

    def logarithm(self, w: Array, less_one: Complex) -> Complex:
        total = np.full(len(w), self._lead)
        for root in self._roots.tolist():
            total += np.log(less_one - root)
        return total

    def slope(self, less_one: complex) -> complex:
        return complex(np.sum(1.0 / (less_one - self._roots)))


class _Sum:
    """A polynomial by its coefficients, with the same of it."""

    def __init__(self, polynomial: Polynomial) -> None:
        self._values = PolynomialValues(polynomial)

    def logarithm(self, w: Array, less_one: Complex) -> Complex:
        logs = np.log(self._values(np.exp(1j * w), less_one)) + self._values.octaves * math.log(2.0)
        return np.asarray(logs, dtype=np.complex128)

    def slope(self, less_one: complex) -> complex:
        return complex(1.0 / self._values.ratio(np.array([less_one]))[0][0])


def _part(polynomial: Polynomial) -> _Product | _Sum:
    left = flint.fmpz_poly(polynomial.coeffs()[zeros(polynomial) :])
    return (_Product if left.degree() <= LARGEST_CERTIFIED else _Sum)(left)
