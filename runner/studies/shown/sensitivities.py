"""Influences of parameters on a measure: regression over the sensors of any study, Sobol indices of Saltelli's design.

Regression: y = b0 + sum b_i x_i by least squares; the standardised coefficient b_i s_i / s_y is the part of the scatter
due to one parameter, and on ranks this holds for any monotonic dependence (Saltelli et al., "Global sensitivity
analysis: the primer" (2008), section 1.2.5). Intervals are Student's: t s sqrt(diag((X'X)^-1)), s^2 the residuals over
n - d - 1 (Draper and Smith, "Applied regression analysis", 3rd ed. (1998), section 5.2).

Factors that move together, with a correlation beyond 0.9 by three standard errors of Fisher's atanh r, 1 / sqrt(n - 3),
are one: their joint effect X_g b_g is known well even if their separate effects are not.

Sobol indices: first order S_i = mean f_B (f_i - f_A) / V, total T_i = mean (f_A - f_i)^2 / 2V, with f_i at A except
parameter i, which is taken from B (Saltelli et al., Computer Physics Communications 181 (2010), table 2, b and f).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from proofmass.blocks.declaration.libraries import need
from proofmass.runner.run.result import Array
from proofmass.runner.studies.outcome.intervals import LEVEL, Interval
from proofmass.runner.studies.outcome.result import StudyResult

MOST_RUNS = 20_000  # whose parameters are drawn again, the first ones
TOGETHER = 0.9  # correlation beyond which two factors are one
_ERRORS = 3.0  # standard errors by which it must exceed that
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

    @property
    def parameter(self) -> str:
        """The names of its parameters as one text."""
        return ", ".join(self.parameters)


@dataclass(frozen=True)
class Regression:
    """Influences, the largest effect first, and the part of the variance that straight lines explain."""

    influences: tuple[Influence, ...]
    explained: float
    explained_of_ranks: float
    runs: int


@dataclass(frozen=True)
class Index:
    """Sobol indices of one parameter, with intervals by resampling the groups."""

    parameter: str
    first: float
    first_interval: Interval
    total: float
    total_interval: Interval


def regression(parameters: Mapping[str, Array], values: Array) -> Regression | None:
    """Return the influences on the values of a measure; None if runs are too few or nothing varies."""
    known = np.isfinite(values)
    y = values[known]
    columns = {name: column[known] for name, column in parameters.items() if _differ(column[known])}
    if len(y) < len(columns) + 3 or not columns or not _differ(y):
        return None
    x = np.column_stack(list(columns.values()))
    groups = _groups(x)
    standardised, halves, explained = _grouped(x, y, groups)
    rank, _, explained_of_ranks = _grouped(_ranks(x), _ranks(y[:, None])[:, 0], groups)
    deviation, names = float(y.std(ddof=1)), list(columns)
    influences = [
        Influence(
            tuple(names[place] for place in group),
            float(b * deviation / x[:, group[0]].std(ddof=1)),
            float(b * deviation),
            float(half * deviation),
            float(b),
            float(rank_b),
        )
        for group, b, half, rank_b in zip(groups, standardised, halves, rank, strict=True)
    ]
    influences.sort(key=lambda influence: -abs(influence.effect))
    return Regression(tuple(influences), explained, explained_of_ranks, len(y))


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
    low, high = np.nanpercentile(resampled, (aside, 100.0 - aside), axis=0)
    first, total = _indices(groups)
    return [
        Index(
            name,
            float(first[i]),
            (float(low[0, i]), float(high[0, i])),
            float(total[i]),
            (float(low[1, i]), float(high[1, i])),
        )
        for i, name in enumerate(study.designed.names)
    ]


def _differ(values: Array) -> bool:
    return values.size > 0 and bool(np.ptp(values) > 0.0)


def _indices(groups: Array) -> Array:
    """First-order and total indices of groups: f_A, f_B, then f_i for each parameter."""
    centred = groups - groups[:, :2].mean()
    a, b, mixed = centred[:, :1], centred[:, 1:2], centred[:, 2:]
    variance = 0.5 * float((a * a + b * b).mean())
    if variance == 0.0:
        return np.full((2, mixed.shape[1]), np.nan)
    return np.array([(b * (mixed - a)).mean(axis=0), 0.5 * ((a - mixed) ** 2).mean(axis=0)]) / variance


def _groups(x: Array) -> list[list[int]]:
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


def _grouped(x: Array, y: Array, groups: list[list[int]]) -> tuple[Any, Any, float]:
    """Return `_standardised` with a column for each group: the joint effect of its columns."""
    if len(groups) == x.shape[1]:
        return _standardised(x, y)
    coefficients, _, _ = _standardised(x, y)
    scaled = (x - x.mean(axis=0)) / x.std(axis=0, ddof=1)
    columns = []
    for group in groups:
        column = scaled[:, group] @ coefficients[group]
        along = float(scaled[:, group[0]] @ column)
        columns.append(scaled[:, group[0]] if len(group) == 1 or along == 0.0 else column * np.sign(along))
    return _standardised(np.column_stack(columns), y)


def _standardised(x: Array, y: Array) -> tuple[Any, Any, float]:
    """Standardised coefficients, halves of their intervals, and the part of the variance that they explain."""
    need("scipy")
    # start-up time: this part of SciPy takes 0.15 s
    from scipy.special import stdtrit

    x = (x - x.mean(axis=0)) / x.std(axis=0, ddof=1)
    y = (y - y.mean()) / y.std(ddof=1)
    coefficients = np.linalg.lstsq(x, y, rcond=None)[0]
    rest = y - x @ coefficients
    free = len(y) - x.shape[1] - 1
    errors = np.sqrt(rest @ rest / free * np.diag(np.linalg.pinv(x.T @ x)))
    return coefficients, stdtrit(free, 0.5 + 0.5 * LEVEL) * errors, 1.0 - float(rest @ rest / (y @ y))


def _ranks(columns: Array) -> Array:
    """Return ranks within each column; equal values share their mean rank."""
    need("scipy")
    # start-up time: scipy.stats takes 0.4 s
    from scipy.stats import rankdata

    return np.asarray(rankdata(columns, axis=0), dtype=float)
