"""Which parameter scatters a measure: regression over the sensors of any study, Sobol indices of Saltelli's design.

Regression: y = b0 + sum b_i x_i by least squares; the standardised coefficient b_i s_i / s_y is the part of the scatter
that goes with one parameter, and on ranks it is so for any monotonic dependence (Saltelli et al., "Global sensitivity
analysis: the primer" (2008), section 1.2.5). Intervals are Student's: t s sqrt(diag((X'X)^-1)), s^2 what is left over
n - d - 1 (Draper and Smith, "Applied regression analysis", 3rd ed. (1998), section 5.2).

Sobol indices: first order S_i = mean f_B (f_i - f_A) / V, total T_i = mean (f_A - f_i)^2 / 2V, with f_i at A but for
parameter i, which is that of B (Saltelli et al., Computer Physics Communications 181 (2010), table 2, b and f).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from proofmass.graphs.study import Study
from proofmass.runner.engine.result import Array
from proofmass.runner.studies.intervals import LEVEL, Interval
from proofmass.runner.studies.result import StudyResult

MOST_RUNS = 20_000  # the first ones, of which parameters are drawn again
_RESAMPLES = 400


@dataclass(frozen=True)
class Influence:
    """What one parameter does to a measure."""

    parameter: str
    slope: float  # measure per parameter, in their units
    effect: float  # change of the measure for a standard deviation of the parameter
    effect_half: float  # half of its interval
    standardised: float
    rank: float  # standardised coefficient of the ranks


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


def drawn_parameters(study: Study, runs: Array, epoch: int) -> dict[str, Array]:
    """Parameters that differ between runs: what each run had at an epoch."""
    rows = [study.drawn(int(run))[epoch] for run in runs]
    table = {name: np.array([row[name] for row in rows], dtype=float) for name in (rows[0] if rows else ())}
    return {name: values for name, values in table.items() if _differ(values)}


def regression(parameters: Mapping[str, Array], values: Array) -> Regression | None:
    """Influence of parameters on the values of a measure; None where runs are too few or nothing scatters."""
    known = np.isfinite(values)
    y = values[known]
    columns = {name: column[known] for name, column in parameters.items() if _differ(column[known])}
    if len(y) < len(columns) + 3 or not columns or not _differ(y):
        return None
    x = np.column_stack(list(columns.values()))
    standardised, halves, explained = _standardised(x, y)
    rank, _, explained_of_ranks = _standardised(_ranks(x), _ranks(y[:, None])[:, 0])
    deviation = float(y.std(ddof=1))
    found = [
        Influence(
            name,
            float(b * deviation / column.std(ddof=1)),
            float(b * deviation),
            float(half * deviation),
            float(b),
            float(rank_b),
        )
        for (name, column), b, half, rank_b in zip(columns.items(), standardised, halves, rank, strict=True)
    ]
    found.sort(key=lambda influence: -abs(influence.effect))
    return Regression(tuple(found), explained, explained_of_ranks, len(y))


def sobol_indices(result: StudyResult, measure: str, epoch: int = 0, point: int = 0) -> list[Index]:
    """First-order and total indices at a point of the sweep; none without Saltelli's design and two whole groups."""
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


def _standardised(x: Array, y: Array) -> tuple[Any, Any, float]:
    """Standardised coefficients, halves of their intervals, and the part of the variance that they explain."""
    from scipy.special import stdtrit

    x = (x - x.mean(axis=0)) / x.std(axis=0, ddof=1)
    y = (y - y.mean()) / y.std(ddof=1)
    coefficients = np.linalg.lstsq(x, y, rcond=None)[0]
    rest = y - x @ coefficients
    free = len(y) - x.shape[1] - 1
    errors = np.sqrt(rest @ rest / free * np.diag(np.linalg.pinv(x.T @ x)))
    return coefficients, stdtrit(free, 0.5 + 0.5 * LEVEL) * errors, 1.0 - float(rest @ rest / (y @ y))


def _ranks(columns: Array) -> Array:
    """Ranks within each column, the mean of theirs for equal values."""
    from scipy.stats import rankdata

    return np.asarray(rankdata(columns, axis=0), dtype=float)
