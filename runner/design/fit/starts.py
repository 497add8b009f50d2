"""Starts from which two exponentials are found: both iterations from every pair of a grid."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

from proofmass.runner.design.fit.alternation import alternate
from proofmass.runner.design.fit.fit import FitReport
from proofmass.runner.design.fit.projection import DOUBLE, refine
from proofmass.runner.design.fit.scale import ScaledReadings
from proofmass.runner.design.fit.verdict import NOTHING, SHORT

GRID = (-4.8, -2.4, -1.2, -0.6, -0.3, 0.3, 0.6, 1.2, 2.4, 4.8)  # exponents times half the range of the temperature


class Arrival(NamedTuple):
    """End of one start; `reached` means the root mean square of the optimum, to a relative 1e-6."""

    start: tuple[float, float]
    iterations: int
    converged: bool
    rmse: float
    reached: bool


@dataclass(frozen=True)
class Arrivals:
    """All starts of one method."""

    method: str
    all: tuple[Arrival, ...]


def from_starts(report: FitReport, grid: Sequence[float] = GRID) -> tuple[Arrivals, Arrivals]:
    """Run both methods from every pair of the grid, without the start that `fit` chooses."""
    readings = report.readings
    scaled, rows = ScaledReadings(readings), len(readings.output)
    enough = report.fits[0].rmse * (1.0 + SHORT) + NOTHING * report.before

    def arrival(start: tuple[float, float], iterations: int, converged: bool, rmse: float) -> Arrival:
        return Arrival(start, iterations, converged, rmse, converged and rmse <= enough)

    alternated, projected = [], []
    for pair in combinations(grid, 2):
        start = scaled.exponents(pair)
        turns = alternate(readings.temperature, readings.output, start)
        alternated.append(arrival(start, turns.iterations, turns.converged, math.sqrt(turns.mean_square)))
        found = refine(DOUBLE, pair, scaled.x, scaled.v)
        rmse = math.sqrt(found.at.squares / rows) * scaled.size
        projected.append(arrival(start, found.iterations, found.converged, rmse))
    return Arrivals("alternation", tuple(alternated)), Arrivals("variable projection", tuple(projected))
