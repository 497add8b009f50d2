"""All roots of a polynomial of hundreds of degrees at once, in double precision.

The method is Aberth's (Communications of the ACM 16, 1973, 339), from the circles of Newton's
polygon (Bini, Numerical Algorithms 13, 1996, 179). Roots are known less 1, and near 1, where the
poles of slow loops lie close together, the polynomial is one in z - 1. Its coefficients are exact,
so its values do not cancel there. Each root is a ball around the last step times the degree, which
holds a root. Those next to the unit circle go on with Newton's method, in as many bits as roots of
small polynomials have.
"""

import math
from itertools import pairwise
from typing import Any

import flint
import numpy as np
import numpy.typing as npt

from proofmass.runner.analysis.linearisation.real_roots import Polynomial, zeros
from proofmass.runner.host.arrays import Array, Complex

_MOST_STEPS = 200
_DOUBTFUL = 1e-6  # part of z - 1 up to which the rounding of a step may end it
_ROUNDINGS = 4.0
_EPSILON = float(np.finfo(float).eps)
_NEAR_ONE = 0.5  # of the degree times |z - 1|, within which powers of z - 1 are summed
_POLISHED = 16  # roots next to the circle, and all that are nearer than
_CLOSE = 1e-9
_INSIDE = 0.25  # size of roots that are not told from each other
_ON_CIRCLE = 1e-30  # radius of a ball on the circle


class PolynomialValues:
    """Values and derivatives of a polynomial with integer coefficients, near z = 1 too."""

    def __init__(self, polynomial: Polynomial) -> None:
        """Take a polynomial; it is counted in the power of two of its largest coefficient, so many `octaves`."""
        self.degree = max(polynomial.degree(), 0)
        coefficients = [int(value) for value in polynomial.coeffs()] or [0]
        shifted = [int(value) for value in polynomial(flint.fmpz_poly([1, 1])).coeffs()] or [0]
        self._finer = self.degree.bit_length()  # octaves in which z - 1 is counted, so that its powers stay small
        self.octaves = max(abs(value).bit_length() for value in coefficients)
        self._powers = np.array([_double(value, self.octaves) for value in coefficients])
        self._about_one = np.array([_double(value, self.octaves + self._finer * k) for k, value in enumerate(shifted)])
        self._reversed = self._powers[::-1]

    def __call__(self, z: Complex, less_one: Complex) -> Complex:
        """Return values at z, of which z - 1 is given too, on the unit circle or inside."""
        return self._parts(z, less_one)[0]

    def _parts(self, z: Complex, less_one: Complex) -> tuple[Complex, Complex, Array]:
        """Return values, derivatives, and what rounding may make of the values."""
        near = self.are_near(less_one)
        value, slope = np.empty_like(z), np.empty_like(z)
        size = np.empty(len(z))
        if near.any():
            scale = 2.0**self._finer
            value[near], slope[near], size[near] = _sums(self._about_one, scale * less_one[near])
            slope[near] *= scale
        if not near.all():
            value[~near], slope[~near], size[~near] = _sums(self._powers, z[~near])
        return value, slope, _ROUNDINGS * _EPSILON * size

    def ratio(self, less_one: Complex) -> tuple[Complex, Array]:
        """Return Newton's step p / p' where z - 1 is given, and what may be rounding."""
        z = 1.0 + less_one
        step, error = np.empty_like(z), np.empty(len(z))
        inside = (np.abs(z) <= 1.0) | self.are_near(less_one)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            if inside.any():
                value, slope, wrong = self._parts(z[inside], less_one[inside])
                step[inside], error[inside] = value / slope, wrong / np.abs(slope)
            if not inside.all():
                w = 1.0 / z[~inside]
                value, slope, size = _sums(self._reversed, w)
                down = self.degree * w * value - slope * w * w  # p'(z) / z^degree
                step[~inside], error[~inside] = value / down, _ROUNDINGS * _EPSILON * size / np.abs(down)
        return step, error

    def are_near(self, less_one: Complex) -> npt.NDArray[np.bool_]:
        """Return whether places are so near to 1 that powers of z - 1 are summed."""
        return np.asarray(np.abs(less_one) * max(self.degree, 1) < _NEAR_ONE)


def many_roots(polynomial: Polynomial, bits: int) -> list[Any] | None:
    """Return the roots with their multiplicity, as balls; those next to the unit circle with about so many bits.

    None where they are not found so well that it is known on which side of the circle each is.
    """
    at_zero = [flint.acb(0)] * zeros(polynomial)
    left = [int(value) for value in polynomial.coeffs()[len(at_zero) :]]
    simple = flint.fmpz_poly(left)
    if simple.degree() < 1:
        return at_zero
    values = PolynomialValues(simple)
    apart_of_one, errors = _iterated(values, _starts(left) - 1.0)
    balls = _balls(simple, apart_of_one, values.degree * errors, bits)
    told = all(ball.is_finite() and _is_told(ball) for ball in balls) and _are_all(simple, balls)
    return at_zero + balls if told else None


def _are_all(polynomial: Polynomial, balls: list[Any]) -> bool:
    """Return whether each ball holds a root of its own: none touches another, but next to 0, and their sum is right."""
    degree = polynomial.degree()
    missing: Any = sum(ball.mid() for ball in balls) + flint.fmpq(int(polynomial[degree - 1]), int(polynomial[degree]))
    return _are_apart([ball for ball in balls if abs(ball.mid()) > _INSIDE]) and bool(abs(missing) < 0.5 * _INSIDE)


def _iterated(values: PolynomialValues, less_one: Complex) -> tuple[Complex, Array]:
    """Return all roots less 1, and the last steps with what rounding adds to them."""
    moving, errors = np.ones(len(less_one), dtype=bool), np.zeros(len(less_one))
    for _ in range(_MOST_STEPS):
        places = np.flatnonzero(moving)
        if not len(places):
            break
        own = less_one[places]
        newton, rounding = values.ratio(own)
        newton = np.where(np.isfinite(newton), newton, 1e-3 * (1.0 + own))
        apart = own[:, None] - less_one[None, :]
        apart[np.arange(len(places)), places] = np.inf
        with np.errstate(divide="ignore", invalid="ignore"):
            step = newton / (1.0 - newton * np.sum(1.0 / apart, axis=1))
        step = np.where(np.isfinite(step), step, newton)
        less_one[places] = own - step
        errors[places] = np.abs(newton) + rounding
        digits = np.where(values.are_near(own), np.abs(own), np.abs(1.0 + own))
        least = np.maximum(_ROUNDINGS * _EPSILON * digits, np.minimum(rounding, _DOUBTFUL * np.abs(own)))
        moving[places] = np.maximum(np.abs(step), np.abs(newton)) > least
    return less_one, errors


def _are_apart(balls: list[Any]) -> bool:
    """Return whether no ball touches another, so that each holds a root of its own."""
    centers = [ball.mid() for ball in balls]
    less_one: Complex = np.array([complex(center - 1) for center in centers], dtype=np.complex128)
    radii = np.array([max(float(ball.real.rad()), float(ball.imag.rad())) for ball in balls])
    order = np.argsort(less_one.real)
    less_one, radii = less_one[order], 2.0 * radii[order]
    widest = float(radii.max(initial=0.0))
    ends = np.searchsorted(less_one.real, less_one.real + radii + widest, side="right")
    return all(
        bool((np.abs(less_one[i + 1 : end] - less_one[i]) > radii[i] + radii[i + 1 : end]).all())
        for i, end in enumerate(ends.tolist())
    )


def _is_told(ball: Any) -> bool:
    """Return whether a ball is beside the unit circle, or so small that it may lie on it."""
    return not abs(ball).contains(1) or float(abs(ball).rad()) < _ON_CIRCLE


def _balls(polynomial: Polynomial, less_one: Complex, errors: Array, bits: int) -> list[Any]:
    """Return balls in conjugate pairs, those next to the circle with more bits."""
    real = np.abs(less_one.imag) <= errors
    upper = less_one.imag > errors
    if 2 * int(upper.sum()) + int(real.sum()) != len(less_one):
        upper, real = np.zeros_like(real), np.zeros_like(real)
    distances = np.abs(np.abs(1.0 + less_one) - 1.0)
    close = max(float(np.sort(distances)[min(_POLISHED, len(distances)) - 1]), _CLOSE)
    slope, balls = polynomial.derivative(), []
    for i in np.flatnonzero(real | upper if real.any() or upper.any() else ~real).tolist():
        place = less_one[i].real if real[i] else less_one[i]
        center = flint.acb(1) + flint.acb(place.real, place.imag)
        if distances[i] <= close:
            ball = _polished(polynomial, slope, center, bits)
        else:
            radius = flint.arb(0, float(errors[i]))
            ball = flint.acb(center.real + radius, center.imag + radius)
        balls += [ball, ball.conjugate()] if upper[i] else [ball]
    return balls


def _polished(polynomial: Polynomial, slope: Polynomial, place: Any, bits: int) -> Any:
    """Return a ball that holds a root next to a place."""
    for _ in range(12):
        step = polynomial(place) / slope(place)
        if not step.is_finite():
            break
        place = (place - step).mid()
        if abs(step) < flint.arb(2) ** (-bits // 2):
            break
    step = polynomial(place) / slope(place)
    radius = flint.arb(0, (polynomial.degree() * abs(step)).upper())
    return flint.acb(place.real + radius, place.imag + radius)


def _double(value: int, octaves: int) -> float:
    """Return an integer over a power of two, as a double."""
    cut = max(abs(value).bit_length() - 64, 0)
    return math.ldexp(float(value >> cut), cut - octaves) if value else 0.0


def _sums(powers: Array, z: Complex) -> tuple[Complex, Complex, Array]:
    """Return a polynomial, its derivative and the sum of the sizes of its terms, where |z| <= 1 or z is near 0."""
    counted = np.flatnonzero(powers)
    if 8 * len(counted) < len(powers):
        size = np.abs(z)
        value, slope, whole = np.zeros_like(z), np.zeros_like(z), np.zeros(len(z))
        for k in counted.tolist():
            term = powers[k] * z ** max(k - 1, 0)
            slope += k * term
            value += term * z if k else term
            whole += abs(powers[k]) * size**k
        return value, slope, whole
    value, slope, whole = np.zeros_like(z), np.zeros_like(z), np.zeros(len(z))
    size = np.abs(z)
    for coefficient in powers[::-1].tolist():
        slope *= z
        slope += value
        value *= z
        value += coefficient
        whole *= size
        whole += abs(coefficient)
    return value, slope, whole


def _starts(coefficients: list[int]) -> Complex:
    """Return where the roots begin: on circles whose radii are the slopes of Newton's polygon."""
    corners = list[tuple[int, float]]()
    for k, value in enumerate(coefficients):
        if not value:
            continue
        point = (k, math.log(abs(value)))
        while len(corners) > 1 and _turns_up(corners[-2], corners[-1], point):
            corners.pop()
        corners.append(point)
    starts = list[complex]()
    for number, ((i, low), (k, high)) in enumerate(pairwise(corners)):
        radius = math.exp((low - high) / (k - i))
        angles = (2.0 * math.pi * np.arange(k - i) + 0.7) / (k - i) + 0.4 * number
        starts += (radius * np.exp(1j * angles)).tolist()
    return np.array(starts, dtype=complex)


def _turns_up(first: tuple[int, float], middle: tuple[int, float], last: tuple[int, float]) -> bool:
    return (middle[1] - first[1]) * (last[0] - first[0]) <= (last[1] - first[1]) * (middle[0] - first[0])
