"""Influences of parameters on a measure: regression over the sensors of any study, Sobol indices of
Saltelli's design.

Regression: y = b0 + sum b_i x_i by least squares; the standardised coefficient b_i s_i / s_y is the
part of the scatter due to one parameter, and on ranks this holds for any monotonic dependence
(Saltelli et al., "Global sensitivity analysis: the primer" (2008), section 1.2.5). Intervals are
Student's: t s sqrt(diag((X'X)^-1)), s^2 the residuals over n - d - 1 (Draper and Smith, "Applied
regression analysis", 3rd ed. (1998), section 5.2).

The share of a factor is b_i s_i / s_y times its correlation with y (Pratt 1987): shares add up to
R^2, also of factors that are correlated.

Factors that move together, with a correlation beyond 0.9 by three standard errors of Fisher's atanh
r, 1 / sqrt(n - 3), are one: their joint effect X_g b_g is known well even if their separate effects
are not.

Sobol indices: first order S_i = mean f_B (f_i - f_A) / V, total T_i = mean (f_A - f_i)^2 / 2V, with
f_i at A except parameter i, which is taken from B (Saltelli et al., Computer Physics Communications
181 (2010), table 2, b and f).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.studies.outcome.intervals import LEVEL, Bounds
from proofmass.runner.studies.outcome.result import StudyResult

MOST_RUNS = 20_000  # whose parameters are drawn again, the first ones
TOGETHER = 0.9  # correlation beyond which two factors are one
_ERRORS = 3.0  # standard errors by which the correlation must exceed that
_RESAMPLES = 400


@dataclass(frozen=True)
class Influence:
    """Effect of one factor on a measure: a parameter, or several that move together, the first one upwards."""

    parameters: tuple[str, ...]
    slope: float  # measure per first parameter, in their units
    effect: float  # change of the measure for a standard deviation of the factor
    effect_half: float  # half of its interval
    standardised: float
    rank: float  # standardised coefficient of the ranks
    share: float  # of the variance; the shares of all factors add up to what is explained

    @property
    def parameter(self) -> str:
        """The names of its parameters as one text."""
        return ", ".join(self.parameters)


@dataclass(frozen=True)
class Regression:
    """Influences, the largest effect first, and the variance that straight lines explain."""

    influences: tuple[Influence, ...]
    explained: float
    explained_of_ranks: float
    runs: int


@dataclass(frozen=True)
class Index:
    """Sobol indices of one parameter, with intervals by resampling the groups."""

    parameter: str
    first: float
    first_interval: Bounds
    total: float
    total_interval: Bounds


class Columns:
    """Factors of some runs that differ among them, prepared for regressions on several measures."""

    def __init__(self, parameters: Mapping[str, AnyArray]) -> None:
        self._columns = {name: column for name, column in parameters.items() if _differ(column)}

    @cached_property
    def x(self) -> AnyArray:
        """A row for each run; only if there are factors."""
        return np.column_stack(list(self._columns.values()))

    @cached_property
    def groups(self) -> list[list[int]]:
        """Places of the columns that are one factor."""
        return _groups(self.x)

    @cached_property
    def plain(self) -> "_Fit":
        """The fit of values."""
        return _Fit(self.x)

    @cached_property
    def ranked(self) -> "_Fit":
        """The fit of ranks."""
        return _Fit(_ranks(self.x))

    def regression(self, values: AnyArray) -> Regression | None:
        """Return the influences on values, none of which is missing; None if runs are too few or nothing varies."""
        names, runs = list(self._columns), len(values)
        if not names or runs < len(names) + 3 or not _differ(values):
            return None
        standardised, halves, correlations, explained = _grouped(self.plain, values, self.groups)
        rank, _, _, explained_of_ranks = _grouped(self.ranked, _ranks(values[:, None])[:, 0], self.groups)
        deviation = float(values.std(ddof=1))
        numbers = (column.tolist() for column in (standardised, halves, correlations, rank))
        influences = []
        for group, b, half, r, rank_b in zip(self.groups, *numbers, strict=True):
            slope = float(b * deviation / self.x[:, group[0]].std(ddof=1))
            factor = tuple(names[place] for place in group)
            influences.append(Influence(factor, slope, b * deviation, half * deviation, b, rank_b, b * r))
        influences.sort(key=lambda influence: -abs(influence.effect))
        return Regression(tuple(influences), explained, explained_of_ranks, runs)


def regression(
    parameters: Mapping[str, AnyArray], values: AnyArray, prepared: Columns | None = None
) -> Regression | None:
    """Return the influences on the values of a measure; None if runs are too few or nothing varies.

    `prepared` are the same parameters, which serve where no value is missing.
    """
    known = np.isfinite(values)
    if known.all():
        return (prepared or Columns(parameters)).regression(values)
    return Columns({name: column[known] for name, column in parameters.items()}).regression(values[known])


def sobol_indices(result: StudyResult, measure: str, epoch: int = 0, point: int = 0) -> list[Index]:
    """Return first-order and total indices at a point of the sweep; none without two whole groups of Saltelli."""
    study, group = result.study, result.study.designed.group
    if study.design != "saltelli":
        return []
    there = {int(run): value for run, value in zip(result.numbers, result[measure][:, epoch], strict=True)}
    sensors = study.runs - study.runs % group
    values = np.array([there.get(sensor * study.points + point, np.nan) for sensor in range(sensors)], dtype=float)
    groups = values.reshape(-1, group)
    groups = groups[np.isfinite(groups).all(axis=1)]
    if len(groups) < 2 or not _differ(groups[:, :2]):
        return []
    dice = np.random.default_rng(study.seed)
    resampled = np.array([_indices(groups[dice.integers(len(groups), size=len(groups))]) for _ in range(_RESAMPLES)])
    aside = 50.0 * (1.0 - LEVEL)
    low, high = np.nanpercentile(resampled, (aside, 100.0 - aside), axis=0).tolist()
    first, total = _indices(groups).tolist()
    columns = first, zip(low[0], high[0], strict=True), total, zip(low[1], high[1], strict=True)
    return [Index(*row) for row in zip(study.designed.names, *columns, strict=True)]


def _differ(values: AnyArray) -> bool:
    return values.size > 0 and bool(np.ptp(values) > 0.0)


def _indices(groups: AnyArray) -> AnyArray:
    """First-order and total indices of groups: f_A, f_B, then f_i for each parameter."""
    centred = groups - groups[:, :2].mean()
    a, b, mixed = centred[:, :1], centred[:, 1:2], centred[:, 2:]
    variance = 0.5 * float((a * a + b * b).mean())
    if variance == 0.0:
        return np.full((2, mixed.shape[1]), np.nan)
    return np.array([(b * (mixed - a)).mean(axis=0), 0.5 * ((a - mixed) ** 2).mean(axis=0)]) / variance


def _groups(x: AnyArray) -> list[list[int]]:
    """Places of the columns that are one factor, by chains of correlations."""
    largest = 1.0 - 2.0**-52  # atanh of less is finite
    fisher = np.arctanh(np.minimum(np.abs(np.atleast_2d(np.corrcoef(x, rowvar=False))), largest))
    close = fisher >= np.arctanh(TOGETHER) + _ERRORS / np.sqrt(len(x) - 3.0)
    groups, left = list[list[int]](), list(range(len(close)))
    while left:
        group, new = list[int](), left[:1]
        while new:
            group += new
            left = [place for place in left if place not in new]
            new = [place for place in left if close[place, group].any()]
        groups.append(sorted(group))
    return groups


class _Fit:
    """Least squares on standardised columns, by their orthogonal factors: X = Q R."""

    def __init__(self, x: AnyArray) -> None:
        self.scaled = (x - x.mean(axis=0)) / x.std(axis=0, ddof=1)
        self.q, self.r = _orthogonal(self.scaled)
        self.spread = np.diag(np.linalg.pinv(self.r.T @ self.r))

    def standardised(self, y: AnyArray) -> tuple[Any, Any, Any, float]:
        """Standardised coefficients, halves of their intervals, correlations with y, and the explained variance."""
        # start-up time: this part of SciPy takes 0.15 s
        from scipy.special import stdtrit

        y = (y - y.mean()) / y.std(ddof=1)
        coefficients = np.linalg.lstsq(self.r, self.q.T @ y, rcond=None)[0]
        rest = y - self.scaled @ coefficients
        free = len(y) - self.scaled.shape[1] - 1
        halves = stdtrit(free, 0.5 + 0.5 * LEVEL) * np.sqrt(rest @ rest / free * self.spread)
        correlations = self.scaled.T @ y / (len(y) - 1.0)
        return coefficients, halves, correlations, 1.0 - float(rest @ rest / (y @ y))


def _orthogonal(x: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Return orthogonal columns and the triangle R with X = Q R, by Gram and Schmidt, done twice (Giraud 2005).

    LAPACK's threads take longer to start than these few columns take; a column that depends on
    others becomes zero.
    """
    q, r = np.zeros(x.shape, order="F"), np.zeros((x.shape[1], x.shape[1]))
    for place, column in enumerate(x.T):
        left = column.copy()
        for _ in range(2):
            along = q[:, :place].T @ left
            left -= q[:, :place] @ along
            r[:place, place] += along
        size = float(np.sqrt(left @ left))
        if size > 1e-13 * np.sqrt(column @ column):
            q[:, place], r[place, place] = left / size, size
    return q, r


def _grouped(fit: _Fit, y: AnyArray, groups: list[list[int]]) -> tuple[Any, Any, Any, float]:
    """Return `standardised` with a column for each group: the joint effect of its columns."""
    if len(groups) == fit.scaled.shape[1]:
        return fit.standardised(y)
    coefficients, columns = fit.standardised(y)[0], []
    for group in groups:
        column = fit.scaled[:, group] @ coefficients[group]
        along = float(fit.scaled[:, group[0]] @ column)
        columns.append(fit.scaled[:, group[0]] if along == 0.0 else math.copysign(1.0, along) * column)
    return _Fit(np.column_stack(columns)).standardised(y)


def _ranks(columns: AnyArray) -> AnyArray:
    """Return ranks within each column; equal values share their mean rank."""
    ranked = np.empty(columns.shape)
    for place, column in enumerate(columns.T):
        _, numbers, counts = np.unique(column, return_inverse=True, return_counts=True)
        ranked[:, place] = (np.cumsum(counts) - 0.5 * (counts - 1.0))[numbers]
    return ranked
