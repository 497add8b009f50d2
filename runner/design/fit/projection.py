"""Variable projection: exponential sums fitted by their exponents alone, the linear coefficients eliminated.

    v = sum over terms of a_i x^(p_i) exp(b_(j_i) x),   r(b) = v - E(b) a(b),   a(b) = E(b)^+ v

The squares of r(b) are minimised by Levenberg and Marquardt's method with Kaufman's Jacobian P D a,
P the projection off the span of E and D the derivatives of E (Golub and Pereyra 1973, Kaufman 1975;
gradient exact). Everything here is dimensionless: x from -1 to 1, v of the size of 1.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from proofmass.runner.host.arrays import AnyArray

LARGEST_EXPONENT = 60.0  # of x: beyond, an exponential acts on a single point
MOST_ITERATIONS = 300
REFINED = 4  # of the scanned starts
CHOOSING = 2000  # rows that choose a start
SCANNED = (-20.0, -8.0, -4.0, -2.0, -1.0, -0.3, 0.3, 1.0, 2.0, 4.0, 8.0, 20.0)
STATIONARY = 1e-8  # cosine of residual and derivatives; 1e-12 of the squares from the optimum
EXACT = 1e-13  # residual against data, of a fit that leaves nothing


class ExponentialFamily(NamedTuple):
    """A sum of exponentials: each term is a power of x times one of the exponentials, or times 1 where `of` is None."""

    name: str
    exponents: int
    terms: tuple[tuple[int | None, int], ...]  # (of which exponent, power of x)

    @property
    def coefficients(self) -> int:
        """Number of coefficients and exponents that the family fits."""
        return self.exponents + len(self.terms)


CONSTANT = ExponentialFamily("a constant", 0, ((None, 0),))
SINGLE = ExponentialFamily("one exponential", 1, ((0, 0),))
DOUBLE_ROOT = ExponentialFamily("two exponentials of one exponent", 1, ((0, 0), (0, 1)))
DOUBLE = ExponentialFamily("two exponentials", 2, ((0, 0), (1, 0)))
DOUBLE_AND_CONSTANT = ExponentialFamily("two exponentials and a constant", 2, ((0, 0), (1, 0), (None, 0)))


class Projected(NamedTuple):
    """The best linear coefficients at given exponents, what they leave, and how that moves with the exponents."""

    exponents: tuple[float, ...]
    linear: AnyArray
    residual: AnyArray
    jacobian: AnyArray

    @property
    def squares(self) -> float:
        """Sum of the squared residuals."""
        return float(self.residual @ self.residual)


class Optimum(NamedTuple):
    """End of the iteration."""

    at: Projected
    iterations: int
    converged: bool


def project(family: ExponentialFamily, exponents: Sequence[float], x: AnyArray, v: AnyArray) -> Projected:
    """Eliminate the linear coefficients; columns are scaled to entries of about 1."""
    waves = [np.exp(b * x - abs(b)) for b in exponents]
    terms = [np.ones_like(x) if of is None else waves[of] * x**power for of, power in family.terms]
    columns = np.stack(terms, axis=1)
    orthogonal, singular, turned = np.linalg.svd(columns, full_matrices=False)
    kept = singular > 1e-14 * singular[0]
    orthogonal, singular, turned = orthogonal[:, kept], singular[kept], turned[kept]
    linear = turned.T @ ((orthogonal.T @ v) / singular)
    derivatives = [np.zeros_like(x) for _ in exponents]
    for (of, _), column, a in zip(family.terms, terms, linear, strict=True):
        if of is not None:
            derivatives[of] = derivatives[of] + a * x * column
    jacobian = np.stack(derivatives, axis=1) if derivatives else np.zeros((len(x), 0))
    jacobian = jacobian - orthogonal @ (orthogonal.T @ jacobian)
    return Projected(tuple(exponents), linear, v - columns @ linear, jacobian)


def refine(family: ExponentialFamily, start: Sequence[float], x: AnyArray, v: AnyArray) -> Optimum:
    """Go from a start to the nearest optimum."""
    here, damping, size = project(family, start, x, v), 1e-3, float(np.linalg.norm(v))
    for iteration in range(MOST_ITERATIONS):
        if _stationary(here, size):
            return Optimum(here, iteration, True)
        gradient, curvature = here.jacobian.T @ here.residual, here.jacobian.T @ here.jacobian
        before = here.squares
        while damping < 1e12:
            ridge = damping * np.diag(np.diag(curvature) + 1e-30 * size**2)
            step = np.linalg.lstsq(curvature + ridge, gradient, rcond=None)[0]
            trial = np.clip(np.asarray(here.exponents) + step, -LARGEST_EXPONENT, LARGEST_EXPONENT)
            there = project(family, tuple(trial.tolist()), x, v)
            if there.squares < before:
                here, damping = there, max(damping / 10.0, 1e-12)
                break
            damping *= 10.0
        else:  # no step leads down: as near as rounding lets it come
            return Optimum(here, iteration, _stationary(here, size, 1e3))
    return Optimum(here, MOST_ITERATIONS, _stationary(here, size))


def best(family: ExponentialFamily, x: AnyArray, v: AnyArray, starts: Sequence[Sequence[float]] = ()) -> Optimum:
    """The best optimum from the given starts and the best few of a scan; the iterations are those of all.

    Of many rows a part chooses the start; the optimum is that of all rows.
    """
    kept = np.argsort(x, kind="stable")[:: max(1, len(x) // CHOOSING)] if len(x) > CHOOSING else slice(None)
    few, levels = x[kept], v[kept]
    scanned = sorted(combinations(SCANNED, family.exponents), key=lambda b: project(family, b, few, levels).squares)
    found = [refine(family, start, few, levels) for start in (*starts, *scanned[:REFINED])]
    lowest = min(found, key=lambda optimum: optimum.at.squares)
    iterations = sum(optimum.iterations for optimum in found)
    if len(few) < len(x):
        lowest = refine(family, lowest.at.exponents, x, v)
        iterations += lowest.iterations
    return lowest._replace(iterations=iterations)


def prony(x: AnyArray, v: AnyArray) -> tuple[float, float] | None:
    """Exponents from the means of four stretches of equal length (Prony 1795), or None where they are not real.

    The integrals of a sum of two exponentials over equal stretches follow the same recurrence as
    its values, and noise moves them less.
    """
    means = list(_stretches(x, v, 4))
    try:
        p, q = np.linalg.solve([[means[1], means[0]], [means[2], means[1]]], [means[2], means[3]])
    except np.linalg.LinAlgError:
        return None
    root = p * p / 4.0 + q
    if root <= 0.0 or p / 2.0 - math.sqrt(root) <= 0.0:
        return None
    step = float(x.max() - x.min()) / 4.0
    low, high = (math.log(p / 2.0 + sign * math.sqrt(root)) / step for sign in (-1.0, 1.0))
    return low, high


def _stretches(x: AnyArray, v: AnyArray, count: int) -> Iterator[float]:
    """Means of the straight-line interpolation over stretches of equal length."""
    knots, where = np.unique(x, return_inverse=True)
    levels = np.bincount(where, weights=v) / np.bincount(where)
    fine = np.linspace(knots[0], knots[-1], 64 * count + 1)
    values = np.interp(fine, knots, levels)
    areas = (values[1:] + values[:-1]) / 2.0
    yield from areas.reshape(count, 64).mean(axis=1).tolist()


def _stationary(here: Projected, size: float, slack: float = 1.0) -> bool:
    left = float(np.linalg.norm(here.residual))
    if left <= EXACT * size * math.sqrt(slack):
        return True
    lengths = np.linalg.norm(here.jacobian, axis=0)
    return bool((np.abs(here.jacobian.T @ here.residual) <= STATIONARY * slack * lengths * left).all())
