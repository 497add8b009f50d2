"""Length of a recording that is needed to know an Allan deviation at an averaging time to a stated part of it.

An estimate with e degrees of freedom scatters by 1 / sqrt(2 e) of itself (`freedom`): 10 % takes 50 of them.
"""

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.runner.analysis.allan.deviations import Allan, dominating
from proofmass.runner.analysis.allan.freedom import AllanStatistic, freedom

_MOST = 1e15  # values


@dataclass(frozen=True)
class Duration:
    """Length of a recording that is needed, and what one of the present length gives; times in seconds."""

    tau: float
    error: float  # standard error of the deviation, as a part of it
    seconds: float
    values: int
    freedom: float
    present_seconds: float
    present_error: float | None  # None where it is too short for any

    def as_data(self) -> dict[str, Any]:
        """The numbers as plain data."""
        return asdict(self)


def duration(of: Allan, tau: float, error: float) -> Duration:
    """Return how long to record; raises `ModelError` for too short an averaging time, and an impossible error."""
    problems = []
    if not of.period * (1.0 - 1e-9) <= tau < math.inf:
        expected = f"at least {of.period:g} s, from one value to the next"
        problems.append(Problem(message="no averaging time", key="tau", got=f"{tau:g} s", expected=expected))
    if not 0.0 < error < 1.0:
        expected = "between 0 and 1, such as 10 %"
        problems.append(Problem(message="no relative error", key="confidence", got=f"{error:g}", expected=expected))
    if problems:
        raise ModelError(problems)
    factor = max(1, round(tau / of.period))
    kind = dominating(of.levels, np.array([factor * of.period]))[0]

    def degrees(values: int) -> float:
        return freedom(AllanStatistic.ALLAN, values + 1, factor, kind)

    wanted = 0.5 / error**2
    low, high = 2 * factor, 4 * factor
    while degrees(high) < wanted and high < _MOST:
        low, high = high, 2 * high
    while high - low > max(1, factor // 100):
        middle = (low + high) // 2
        low, high = (low, middle) if degrees(middle) >= wanted else (middle, high)
    present = 1.0 / math.sqrt(2.0 * degrees(of.values)) if of.values > 2 * factor else None
    return Duration(factor * of.period, error, high * of.period, high, degrees(high), of.values * of.period, present)
