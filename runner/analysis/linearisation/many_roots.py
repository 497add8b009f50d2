"""All roots of a polynomial of hundreds of degrees at once, in double precision (Aberth, Communications ACM 16, 1973, 339).

They begin on the circles of Newton's polygon (Bini, Numerical Algorithms 13, 1996, 179). Near z = 1, where the poles of
slow loops lie close together, the polynomial is that of z - 1, whose coefficients are exact: its value does not cancel
there. Each root is a ball around the last step times the degree, which holds a root. Those next to the unit circle go on
with Newton's method in as many bits as roots of small polynomials have.
"""

import math
from typing import Any

import flint
import numpy as np

from proofmass.runner.analysis.linearisation.real_roots import Polynomial
from proofmass.runner.host.arrays import Array, Complex

_MOST_STEPS = 200
_DOUBTFUL = 1e-6  # rounding of a step up to which it may be the last
_ROUNDINGS = 4.0
_EPSILON = float(np.finfo(float).eps)
_NEAR_ONE = 0.5  # of the degree times |z - 1|, within which powers of z - 1 are summed
_POLISHED = 16  # roots next to the circle, and all that are nearer than
_CLOSE = 1e-9
_ON_CIRCLE = 1e-30  # radius of a ball on the circle


class Values:
    """Values and derivatives of a polynomial with integer coefficients, to rounding, near z = 1 too."""

    def __init__(self, polynomial: Polynomial, octaves: int = 0) -> None:
        """Take a polynomial over a power of two; by default that of its largest coefficient."""
        self.degree = max(polynomial.degree(), 0)
        coefficients = [int(value) for value in polynomial.coeffs()] or [0]
        shifted = [int(value) for value in polynomial(flint.fmpz_poly([1, 1])).coeffs()] or [0]
        self._finer = self.degree.bit_length()  # octaves in which z - 1 is counted, so that its powers stay small
        unit = octaves or octaves_of(polynomial)
        self._powers = np.array([_double(value, unit) for value in coefficients])
        self._about_one = np.array([_double(value, unit + self._finer * k) for k, value in enumerate(shifted)])
        self._reversed = self._powers[::-1]

    def __call__(self, z: Complex, less_one: Complex) -> Complex:
        """Return values at z, of which z - 1 is given too, on the unit circle or inside."""
        return self._parts(z, less_one)[0]

    def _parts(self, z: Complex, less_one: Complex) -> tuple[Complex, Complex, Array]:
        """Return values, derivatives, and what rounding may make of the values."""
        near = np.abs(less_one) * max(self.degree, 1) < _NEAR_ONE
        value, slope = np.empty_like(z), np.empty_like(z)
        size = np.empty(len(z))
        if near.any():
            scale = 2.0**self._finer
            value[near], slope[near], size[near] = _sums(self._about_one, scale * less_one[near])
            slope[near] *= scale
        if not near.all():
            value[~near], slope[~near], size[~near] = _sums(self._powers, z[~near])
        return value, slope, _ROUNDINGS * _EPSILON * size

    def ratio(self, z: Complex) -> tuple[Complex, Array]:
        """Return Newton's step p / p', and the part of it that may be rounding."""
        step, error = np.empty_like(z), np.empty(len(z))
        inside = np.abs(z) <= 1.0
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            if inside.any():
                value, slope, wrong = self._parts(z[inside], z[inside] - 1.0)
                step[inside], error[inside] = value / slope, wrong / np.abs(slope)
            if not inside.all():
                w = 1.0 / z[~inside]
                value, slope, size = _sums(self._reversed, w)
                down = self.degree * w * value - slope * w * w  # p'(z) / z^degree
                step[~inside], error[~inside] = value / down, _ROUNDINGS * _EPSILON * size / np.abs(down)
        return step, error


def many_roots(polynomial: Polynomial, bits: int) -> list[Any] | None:
    """Return the roots with their multiplicity, as balls; those next to the unit circle with about so many bits.

    None where they are not found so well that it is known on which side of the circle each is.
    """
    zeros, left = 0, [int(value) for value in polynomial.coeffs()]
    while left and not left[0]:
        zeros, left = zeros + 1, left[1:]
    simple = flint.fmpz_poly(left)
    values = Values(simple)
    z = _starts(left)
    moving = np.ones(len(z), dtype=bool)
    errors = np.zeros(len(z))
    for _ in range(_MOST_STEPS):
        places = np.flatnonzero(moving)
        if not len(places):
            break
        newton, rounding = values.ratio(z[places])
        newton = np.where(np.isfinite(newton), newton, 1e-3 * z[places])
        apart = z[places, None] - z[None, :]
        apart[np.arange(len(places)), places] = np.inf
        with np.errstate(divide="ignore", invalid="ignore"):
            step = newton / (1.0 - newton * np.sum(1.0 / apart, axis=1))
        step = np.where(np.isfinite(step), step, newton)
        z[places] -= step
        errors[places] = np.abs(newton) + rounding
        least = np.maximum(_ROUNDINGS * _EPSILON * np.abs(z[places]), np.minimum(rounding, _DOUBTFUL))
        moving[places] = np.maximum(np.abs(step), np.abs(newton)) > least
    balls = _balls(simple, z, values.degree * errors, bits)
    told = all(ball.is_finite() and _is_told(ball) for ball in balls)
    return [flint.acb(0)] * zeros + balls if told else None


def _is_told(ball: Any) -> bool:
    """Return whether a ball is on one side of the unit circle, or so small that its root may lie on it."""
    return not abs(ball).contains(1) or float(abs(ball).rad()) < _ON_CIRCLE


def _balls(polynomial: Polynomial, z: Complex, errors: Array, bits: int) -> list[Any]:
    """Return balls in conjugate pairs, those next to the circle with more bits."""
    real = np.abs(z.imag) <= errors
    upper = np.flatnonzero(~real & (z.imag > 0.0))
    if 2 * len(upper) + int(real.sum()) != len(z):
        upper, real = np.arange(0), np.zeros(len(z), dtype=bool)
    distances = np.abs(np.abs(z) - 1.0)
    last = np.sort(distances)[min(_POLISHED, len(z)) - 1] if len(z) else 0.0
    slope, balls = polynomial.derivative(), []
    alone = [i for i in range(len(z)) if real[i]] if real.any() or len(upper) else list(range(len(z)))
    for i in [*alone, *upper.tolist()]:
        center = flint.acb(float(z[i].real), 0.0 if real[i] else float(z[i].imag))
        if distances[i] <= max(last, _CLOSE):
            ball = _polished(polynomial, slope, center, bits)
        else:
            radius = flint.arb(0, float(errors[i]))
            ball = flint.acb(center.real + radius, 0 if real[i] else center.imag + radius)
        balls += [ball, ball.conjugate()] if i in upper else [ball]
    return balls


def _polished(polynomial: Polynomial, slope: Polynomial, place: Any, bits: int) -> Any:
    """Return a ball that holds a root next to a place."""
    step = flint.acb(0)
    for _ in range(12):
        step = polynomial(place) / slope(place)
        if not step.is_finite():
            break
        place = (place - step).mid()
        if abs(step) < flint.arb(2) ** (-bits // 2):
            break
    step = polynomial(place) / slope(place)
    radius = flint.arb(0, (polynomial.degree() * abs(step)).upper())
    return flint.acb(place.real + radius, 0 if place.imag == 0 else place.imag + radius)


def octaves_of(polynomial: Polynomial) -> int:
    """Return the bits of the largest coefficient."""
    return max((abs(int(value)).bit_length() for value in polynomial.coeffs()), default=1)


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
        while len(corners) > 1 and _turns_up(*corners[-2:], point):
            corners.pop()
        corners.append(point)
    starts = list[complex]()
    for number, ((i, low), (k, high)) in enumerate(zip(corners, corners[1:], strict=False)):
        radius = math.exp((low - high) / (k - i))
        angles = (2.0 * math.pi * np.arange(k - i) + 0.7) / (k - i) + 0.4 * number
        starts += (radius * np.exp(1j * angles)).tolist()
    return np.array(starts, dtype=complex)


def _turns_up(first: tuple[int, float], middle: tuple[int, float], last: tuple[int, float]) -> bool:
    return (middle[1] - first[1]) * (last[0] - first[0]) <= (last[1] - first[1]) * (middle[0] - first[0])
