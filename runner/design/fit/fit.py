"""Fits of a temperature law to readings: two exponentials by two methods, and polynomials to compare with.

    V = a1 exp(b1 T) + a2 exp(b2 T)   (Liu, Li, Shen, eq. 1),   V = c0 + c1 T + ... + cn T^n

All are least squares. The intervals are those of the linearised model with independent errors of
one size (Student's distribution); findings tell where that does not hold.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.design.fit.alternation import TOLERANCE, alternate, convergence_rate
from proofmass.runner.design.fit.data import Readings
from proofmass.runner.design.fit.projection import DOUBLE, best, prony
from proofmass.runner.design.fit.scale import ScaledReadings, half_widths
from proofmass.runner.design.fit.verdict import lagging, notes, undetermined
from proofmass.runner.host.arrays import AnyArray

ORDERS = (3, 4)


class Coefficient(NamedTuple):
    """A fitted number and half of its confidence interval; infinite if undetermined."""

    name: str
    value: float
    half_width: float
    unit: str


@dataclass(frozen=True)
class Fit:
    """One model, fitted by one method."""

    model: str
    method: str
    coefficients: tuple[Coefficient, ...]
    residual: AnyArray
    rmse: float  # root of the mean square of the residual
    r_squared: float
    after: float  # peak to peak of the residual
    iterations: int = 1
    converged: bool = True

    @property
    def values(self) -> dict[str, float]:
        """The coefficients by name."""
        return {c.name: c.value for c in self.coefficients}


@dataclass(frozen=True)
class FitReport:
    """All fits of one set of readings, and findings about them.

    `fits` holds two exponentials by variable projection, then by alternation, then the polynomials.
    A finding that is not a note says why the coefficients of the two exponentials are not
    determined.
    """

    readings: Readings
    before: float  # peak to peak of the output
    fits: tuple[Fit, ...]
    rate: float  # factor of an error per iteration of the alternation, at the optimum
    findings: tuple[Problem, ...]

    @property
    def determined(self) -> bool:
        """True if the readings determine the two exponentials."""
        return all(finding.note for finding in self.findings)


def fit(
    readings: Readings,
    orders: Sequence[int] = ORDERS,
    start: tuple[float, float] | None = None,
    tolerance: float = TOLERANCE,
) -> FitReport:
    """Fit all models; the alternation starts from the exponents `start`, or from Prony's.

    Raises `ModelError` if the start or the exponentials are out of range, with the reason if the
    readings do not determine them.
    """
    scaled = ScaledReadings(readings)
    if start:
        scaled.refuse(start, "start nearer to zero")
    guess = prony(scaled.x, scaled.v)
    if guess and not scaled.reaches(scaled.exponents(guess)):
        guess = None
    optimum = best(DOUBLE, scaled.x, scaled.v, [guess] if guess else [])
    wrong = undetermined(readings, scaled, optimum)
    if wrong is not None and not scaled.reaches(scaled.exponents(optimum.at.exponents)):
        raise wrong.error
    a, b = scaled.unscaled(optimum)
    projected = _exponentials(readings, "variable projection", a, b, optimum.iterations, optimum.converged)
    begin = start or scaled.exponents(guess or optimum.at.exponents)
    turns = alternate(readings.temperature, readings.output, begin, tolerance)
    alternated = _exponentials(readings, "alternation", turns.a, turns.b, turns.iterations, turns.converged)
    known = tuple(order for order in orders if order < len(np.unique(readings.temperature)))
    fits = (projected, alternated, *(_polynomial(readings, scaled, order) for order in known))
    values = projected.values
    rate = convergence_rate(readings.temperature, (values["a1"], values["a2"]), (values["b1"], values["b2"]))
    before = float(np.ptp(readings.output))
    vague = [c.name for c in projected.coefficients if not c.half_width < abs(c.value)]
    noted = (
        *notes(readings, projected.residual, vague),
        *lagging(projected.rmse, alternated.rmse, before, turns.iterations),
    )
    return FitReport(readings, before, fits, rate, noted if wrong is None else (wrong, *noted))


def _exponentials(
    readings: Readings,
    method: str,
    a: tuple[float, float],
    b: tuple[float, float],
    iterations: int,
    converged: bool,
) -> Fit:
    """A fit of two exponentials, the falling one (or the slower) first."""
    (b1, a1), (b2, a2) = sorted(zip(b, a, strict=True))
    t = readings.temperature
    first, second = np.exp(b1 * t), np.exp(b2 * t)
    jacobian = np.stack([first, a1 * t * first, second, a2 * t * second], axis=1)
    residual = readings.output - a1 * first - a2 * second
    per = f"1/{_factor(readings.temperature_unit)}" if readings.temperature_unit else ""
    units = (readings.output_unit, per) * 2
    widths = half_widths(jacobian, residual)
    named = zip(("a1", "b1", "a2", "b2"), (a1, b1, a2, b2), widths, units, strict=True)
    coefficients = tuple(Coefficient(*each) for each in named)
    return Fit("two exponentials", method, coefficients, *_sizes(readings, residual), iterations, converged)


def _polynomial(readings: Readings, scaled: ScaledReadings, order: int) -> Fit:
    """Fit in the scaled temperature, where powers are far from parallel, then convert to zero temperature."""
    powers = np.vander(scaled.x, order + 1, increasing=True)
    solution = np.linalg.lstsq(powers, readings.output, rcond=None)[0]
    residual = readings.output - powers @ solution
    turn = np.zeros((order + 1, order + 1))  # x^k = ((T - middle) / half)^k in powers of T
    for k in range(order + 1):
        for j in range(k + 1):
            turn[j, k] = math.comb(k, j) * (-scaled.middle) ** (k - j) / scaled.half**k
    values = turn @ solution
    widths = half_widths(powers @ np.linalg.inv(turn), residual)
    t, v = readings.temperature_unit, readings.output_unit
    units = [v, f"{_factor(v)}/{_factor(t)}", *(f"{_factor(v)}/{_factor(t)}^{k}" for k in range(2, order + 1))]
    coefficients = tuple(
        Coefficient(f"c{k}", value, width, unit if t and v else "")
        for k, (value, width, unit) in enumerate(zip(values.tolist(), widths, units, strict=True))
    )
    return Fit(f"polynomial of order {order}", "least squares", coefficients, *_sizes(readings, residual))


def _sizes(readings: Readings, residual: AnyArray) -> tuple[AnyArray, float, float, float]:
    """Return the residual with the root of its mean square, R^2, and its peak to peak."""
    squares, centred = float(residual @ residual), readings.output - readings.output.mean()
    r_squared = 1.0 - squares / float(centred @ centred)
    return residual, math.sqrt(squares / len(residual)), r_squared, float(np.ptp(residual))


def _factor(unit: str) -> str:
    """Return a unit for use in a product."""
    return unit if unit.isalnum() else f"({unit})"
