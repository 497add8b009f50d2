"""Tests whether readings determine two exponentials, against simpler laws and one with a constant.

They do not if a simpler law is not worse by Fisher's test, if an interval contains zero, or if an
exponent lies at its bound.
"""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from proofmass.blocks.declaration.problem import Problem, shown
from proofmass.runner.design.fit.data import Readings
from proofmass.runner.design.fit.projection import (
    CONSTANT,
    DOUBLE,
    DOUBLE_AND_CONSTANT,
    DOUBLE_ROOT,
    LARGEST_EXPONENT,
    SINGLE,
    ExponentialFamily,
    Optimum,
    best,
)
from proofmass.runner.design.fit.scale import ScaledReadings
from proofmass.runner.host.arrays import AnyArray

SIGNIFICANT = 0.01  # chance of a simpler law to look this much worse by accident
WORTH_A_CONSTANT = 0.9  # of the root mean square, left when a constant is fitted too
SHORT = 1e-6  # of the root mean square: the alternation counts as having arrived
FEW = 5  # degrees of freedom
LEVEL = 1e-3  # an exponential that changes by no more over half the range is a constant
LARGE_MEAN = 2.0  # against the range of the output
NOTHING = 1e-12  # of the range of the output: a residual that is rounding
ROUGH, ROUGHER = 0.1, 4.0  # when the columns look swapped


def undetermined(readings: Readings, scaled: ScaledReadings, optimum: Optimum) -> Problem | None:
    """Return why the readings do not determine two exponentials, or None if they do."""
    return next(_reasons(readings, scaled, optimum), None)


def _reasons(readings: Readings, scaled: ScaledReadings, optimum: Optimum) -> Iterator[Problem]:
    """The deepest reason first."""
    x, v, exponents = scaled.x, scaled.v, scaled.intervals(optimum)
    squares, range_of_v = optimum.at.squares, float(np.ptp(v))
    floor = len(v) * (NOTHING * range_of_v) ** 2

    def enough(family: ExponentialFamily) -> bool:
        return not _better(best(family, x, v).at.squares, squares, DOUBLE, family, len(v), floor)

    forward, backward = roughness(x, v), roughness(v, x)
    if forward > ROUGH and forward > ROUGHER * backward:
        names = shown(readings.output_name), shown(readings.temperature_name)
        yield _problem(
            "the temperature follows the output more closely than the output the temperature: the columns look swapped",
            readings.output_name,
            f"for the other order say --temperature {names[0]} --output {names[1]}",
        )
    simpler = next((family for family in (CONSTANT, SINGLE, DOUBLE_ROOT) if enough(family)), None)
    if simpler is not None and len(v) - DOUBLE.coefficients < FEW:
        message = f"{len(v)} rows are too few to tell two exponentials from {simpler.name}"
        yield _problem(message, readings.source, "measure at more temperatures")
    if simpler is CONSTANT:
        yield _problem("does not depend on the temperature: a constant fits as well", readings.output_name, "")
    if simpler is SINGLE:
        hint = "the readings determine a single exponential; a polynomial of low order serves too"
        yield _problem("one exponential is enough: the second is not determined", "a2, b2", hint)
    if max(map(abs, optimum.at.exponents)) >= LARGEST_EXPONENT:
        hint = "check that reading, or measure more temperatures there"
        yield _problem("an exponential acts on a single point", "b1, b2", hint)
    if simpler is DOUBLE_ROOT or not all(math.isfinite(width) for _, width in exponents):
        hint = "only their sum is determined; a polynomial of order 3 has as many coefficients"
        yield _problem("the two exponents cannot be told apart", "b1, b2", hint)
    yield from _constant_left(readings, scaled, squares, floor)
    for name, (exponent, width) in zip(("b1", "b2"), exponents, strict=True):
        if abs(exponent) * scaled.half < LEVEL or not abs(exponent) > width:
            hint = "its exponential acts as a constant: take that off with --offset"
            yield _problem("cannot be told from 0", name, hint, f"{exponent:.3g} +- {width:.2g}")
    if not optimum.converged:
        yield _problem("the iteration did not converge", "two exponentials", "the readings do not fix the exponents")


def _constant_left(readings: Readings, scaled: ScaledReadings, squares: float, floor: float) -> Iterator[Problem]:
    """Yield a problem if the output has a constant above the effect of the temperature."""
    rows = len(scaled.v)
    if rows <= DOUBLE_AND_CONSTANT.coefficients:
        return
    fitted = best(DOUBLE_AND_CONSTANT, scaled.x, scaled.v).at
    better = _better(squares, fitted.squares, DOUBLE_AND_CONSTANT, DOUBLE, rows, floor)
    if not better or fitted.squares > WORTH_A_CONSTANT**2 * squares:
        return
    constant = float(fitted.linear[-1]) * scaled.size
    if abs(constant) > float(np.ptp(readings.output)):
        hint = f"take it off with --offset, about {constant:.6g}"
        yield _problem("a constant is left in the output, larger than what the temperature does", "a1, a2", hint)


def notes(readings: Readings, residual: AnyArray, vague: Sequence[str]) -> Iterator[Problem]:
    """Yield further notes; `vague` are coefficients that are uncertain by their own size."""
    rows = len(readings.output)
    if rows - DOUBLE.coefficients < FEW:
        yield _note(f"{rows} rows for {DOUBLE.coefficients} coefficients: the intervals are wide", readings.source)
    mean, span = float(readings.output.mean()), float(np.ptp(readings.output))
    if abs(mean) > LARGE_MEAN * span:
        message = f"has a mean of {mean:.3g} and moves by {span:.3g}: subtract what does not depend on the temperature"
        yield _note(f"{message} with --offset", readings.output_name)
    pairs = np.stack([readings.temperature, readings.output], axis=1)
    repeated = rows - len(np.unique(pairs, axis=0))
    if repeated:
        yield _note(
            f"{repeated} of {rows} rows repeat another exactly: the intervals count them as measured", readings.source
        )
    if vague:
        yield _note("known no better than by its own size", ", ".join(vague))
    size = float(residual @ residual)
    if rows > 10 and size > 0.0 and float((np.diff(residual) ** 2).sum()) < size:  # 2 size where independent
        yield _note(
            "neighbouring residuals are alike (hysteresis, drift, or another law): the intervals are too narrow",
            readings.source,
        )


def lagging(optimum: float, reached: float, range_of_output: float, iterations: int) -> tuple[Problem, ...]:
    """Return a note if the alternation ended short of the optimum; both are root mean squares."""
    if reached <= optimum * (1.0 + SHORT) + NOTHING * range_of_output:
        return ()
    above = 100.0 * (reached / optimum - 1.0) if optimum else math.inf
    return (_note(f"ended {above:.2g} % above the optimum after {iterations} iterations", "alternation"),)


def roughness(x: AnyArray, v: AnyArray) -> float:
    """Return how much v jumps from one x to the next: 0 for a smooth function, about 1 else."""
    knots, where = np.unique(x, return_inverse=True)
    levels = np.bincount(where, weights=v) / np.bincount(where)
    spread = float(levels.var()) * 2.0 * (len(knots) - 1)
    return float((np.diff(levels) ** 2).sum()) / spread if spread else 0.0


def _better(
    simple: float, rich: float, family: ExponentialFamily, simpler: ExponentialFamily, rows: int, floor: float
) -> bool:
    """Return whether the richer family fits significantly better, by Fisher's test of both sums of squares."""
    # start-up time: this part of SciPy takes 0.15 s
    from scipy.special import fdtrc

    free, more = rows - family.coefficients, family.coefficients - simpler.coefficients
    ratio = max(simple - rich, 0.0) / more / ((rich + floor) / max(free, 1))
    return math.isfinite(ratio) and float(fdtrc(more, max(free, 1), ratio)) < SIGNIFICANT and simple > floor


def _problem(message: str, key: str, hint: str, got: str = "") -> Problem:
    return Problem(message=message, key=key, hint=hint, got=got)


def _note(message: str, key: str) -> Problem:
    return Problem(message=message, key=key, note=True)
