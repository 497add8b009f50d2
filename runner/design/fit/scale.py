"""Readings without dimension, results in units of the readings, and confidence intervals."""

import math
from collections.abc import Sequence

import numpy as np

from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.design.fit.alternation import LARGEST_ARGUMENT
from proofmass.runner.design.fit.data import Readings
from proofmass.runner.design.fit.projection import Optimum
from proofmass.runner.host.arrays import AnyArray

CONFIDENCE = 0.95


class ScaledReadings:
    """Readings without dimension: x from -1 to 1, v at most 1."""

    def __init__(self, readings: Readings) -> None:
        t = readings.temperature
        self.middle, self.half = float(t.max() + t.min()) / 2.0, float(np.ptp(t)) / 2.0
        self.size = float(np.abs(readings.output).max())
        self.x, self.v = (t - self.middle) / self.half, readings.output / self.size
        self.largest = float(np.abs(t).max())

    def exponents(self, scaled: Sequence[float]) -> tuple[float, float]:
        """Two exponents in units of the temperature."""
        first, second = scaled
        return first / self.half, second / self.half

    def intervals(self, optimum: Optimum) -> list[tuple[float, float]]:
        """The two exponents in ascending order, each with half the width of its interval."""
        columns = []
        for a, exponent in zip(optimum.at.linear.tolist(), optimum.at.exponents, strict=True):
            wave = np.exp(exponent * self.x - abs(exponent))
            columns += [wave, a * self.x * wave]
        _, first, _, second = half_widths(np.stack(columns, axis=1), optimum.at.residual)
        exponents = zip(self.exponents(optimum.at.exponents), (first / self.half, second / self.half), strict=True)
        return sorted(exponents)

    def unscaled(self, optimum: Optimum) -> tuple[tuple[float, float], tuple[float, float]]:
        """Linear coefficients and exponents of two exponentials, at zero temperature."""
        b = self.exponents(optimum.at.exponents)
        self.refuse(b, f"take a constant off the temperatures, such as {self.middle:.3g}")
        pairs = zip(optimum.at.linear.tolist(), optimum.at.exponents, b, strict=True)
        first, second = (a * self.size * math.exp(-abs(e) - slope * self.middle) for a, e, slope in pairs)
        return (first, second), b

    def reaches(self, exponents: tuple[float, float]) -> bool:
        """Return whether such steep exponentials, from zero temperature, can be computed."""
        return max(map(abs, exponents)) * self.largest <= LARGEST_ARGUMENT

    def refuse(self, exponents: tuple[float, float], hint: str) -> None:
        """Raise `ModelError` if they cannot."""
        steepest = max(exponents, key=abs)
        if not self.reaches(exponents):
            raise Problem(
                message="the temperatures are too far from zero for such steep exponentials",
                got=f"exponent {steepest:g} at {self.largest:g}",
                hint=hint,
            ).error


def half_widths(jacobian: AnyArray, residual: AnyArray) -> list[float]:
    """Half the width of the 95 % interval of each coefficient; infinite if it adds nothing."""
    # start-up time: this part of SciPy takes 0.15 s
    from scipy.special import stdtrit

    rows, count = jacobian.shape
    free = rows - count
    lengths = np.linalg.norm(jacobian, axis=0)
    if free < 1 or not lengths.all():
        return [math.inf] * count
    _, singular, turned = np.linalg.svd(jacobian / lengths, full_matrices=False)
    if singular[-1] < 1e-12 * singular[0]:
        return [math.inf] * count
    spread = np.sqrt(((turned.T / singular) ** 2).sum(axis=1)) / lengths
    deviation = math.sqrt(float(residual @ residual) / free)
    return list((float(stdtrit(free, (1.0 + CONFIDENCE) / 2.0)) * deviation * spread).tolist())
