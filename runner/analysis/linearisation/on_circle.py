"""An exact quotient N / D of many states, on the unit circle, to rounding: also next to 1, where a slow loop's poles lie."""

import flint
import numpy as np

from proofmass.runner.analysis.linearisation.many_roots import Values, octaves_of
from proofmass.runner.analysis.linearisation.rational import Transfer
from proofmass.runner.analysis.linearisation.real_roots import Polynomial
from proofmass.runner.host.arrays import Array, Complex


class OnCircle:
    """L = N / D = z^-late N' / D', neither of N' and D' with the root 0."""

    def __init__(self, loop: Transfer) -> None:
        """Take a quotient in z."""
        parts = loop.numerator, loop.denominator
        octaves = max(map(octaves_of, parts))
        self.above, self.below = (Values(without_zeros(part), octaves) for part in parts)
        self.late = zeros(loop.denominator) - zeros(loop.numerator)

    def values(self, w: Array) -> Complex:
        """Return L at angles."""
        top, bottom = self.parts(w)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(top / bottom)

    def parts(self, w: Array) -> tuple[Complex, Complex]:
        """Return z^-late N' and D' at angles."""
        z, less_one = np.exp(1j * w), 2j * np.sin(0.5 * w) * np.exp(0.5j * w)
        return np.exp(-1j * w * self.late) * self.above(z, less_one), self.below(z, less_one)

    def turning(self, z: complex) -> complex:
        """Return L' / L by the angle."""
        place, turning = np.array([z]), -1j * self.late
        for part, sign in ((self.above, 1j), (self.below, -1j)):
            turning += sign * complex(z / part.ratio(place)[0][0]) if part.degree else 0.0
        return turning


def zeros(polynomial: Polynomial) -> int:
    """Return how often a polynomial has the root 0."""
    return next((k for k, value in enumerate(polynomial.coeffs()) if value != 0), 0)


def without_zeros(polynomial: Polynomial) -> Polynomial:
    """Return a polynomial without the root 0."""
    return flint.fmpz_poly(polynomial.coeffs()[zeros(polynomial) :])
