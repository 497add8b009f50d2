"""Overlapping Allan, overlapping Hadamard and modified Allan deviations (Riley, NIST SP 1065, 2008, section 5).

With x the running integral of the signal and tau = m T:

    Allan     s^2 = mean (x[i+2m] - 2 x[i+m] + x[i])^2 / (2 tau^2)
    Hadamard  s^2 = mean (x[i+3m] - 3 x[i+2m] + 3 x[i+m] - x[i])^2 / (6 tau^2)
    modified  s^2 = mean (mean over m neighbours of the second differences)^2 / (2 tau^2)

A constant part of the signal, and of Hadamard's a linear one, drops out.

An estimate with e degrees of freedom scatters by 1 / sqrt(2 e) of itself (`freedom`): 10 % takes 50
of them. So a recording needs some length to tell a deviation to a stated part of it.
"""

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.special import gammaincinv

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.runner.analysis.allan.field_units import field_unit, in_field_unit, word_of
from proofmass.runner.analysis.allan.freedom import AllanStatistic, freedom
from proofmass.runner.analysis.allan.levels import CONFIDENCE, NAMES, Levels, allan_terms, fitted
from proofmass.runner.analysis.spectrum.series import Series, as_series, enough
from proofmass.runner.host.arrays import Array
from proofmass.runner.host.notebook import Plotted, Told

PER_DECADE = 20
FEWEST = 64  # values
_ALPHA = {"N": 0, "B": -1, "K": -2, "Q": 2}  # exponent of frequency in the density of each
_MOST = 1e15  # values of a recording


@dataclass(frozen=True, eq=False)
class Curve:
    """One deviation over averaging time, with the interval of 95 % by its degrees of freedom."""

    statistic: AllanStatistic
    taus: Array  # seconds
    deviation: Array
    low: Array
    high: Array
    freedom: Array

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        columns = {"tau_s": self.taus, "deviation": self.deviation, "low": self.low, "high": self.high}
        return {name: values.tolist() for name, values in columns.items()} | {
            "degrees_of_freedom": self.freedom.tolist()
        }


@dataclass(frozen=True, eq=False, repr=False)
class Allan(Told, Plotted):
    """The deviations of a signal and the coefficients of its noise.

    >>> import numpy
    >>> from proofmass import allan
    >>> rate = numpy.random.default_rng(1).standard_normal(20000)  # 0.1 deg/s/sqrt(Hz) at 100 Hz
    >>> answer = allan(rate, rate=100.0, unit="deg/s")
    >>> answer.period, answer.values, len(answer.levels.levels)
    (0.01, 20000, 4)
    """

    name: str  # of the signal
    unit: str  # of its values
    period: float  # seconds from value to value
    values: int  # number of them
    curves: dict[AllanStatistic, Curve]  # Allan, Hadamard and modified deviations by averaging time
    levels: Levels  # N, B, K and Q with intervals

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`; coefficients in the signal's and data sheets' units."""
        return {
            "signal": self.name,
            "unit": self.unit,
            "rate_hz": 1.0 / self.period,
            "values": self.values,
            "confidence": CONFIDENCE,
            "deviations": {name: curve.as_data() for name, curve in self.curves.items()},
            "coefficients": {level.name: level_data(level, self.unit) for level in self.levels.levels},
        }


def level_data(level: Any, unit: str) -> dict[str, Any]:
    """A coefficient as plain data."""
    numbers = {"value": level.value if level.seen else None, "low": level.low, "high": level.high}
    in_field = {name: None if v is None else in_field_unit(level.name, v, unit) for name, v in numbers.items()}
    words = {"is": word_of(level.name, unit), "field_unit": field_unit(level.name, unit)}
    return words | numbers | {f"field_{name}": v for name, v in in_field.items()}


def allan(signal: Any, *, rate: float = 0.0, unit: str = "1") -> Allan:
    """Allan, Hadamard and modified Allan deviations of a trace, a series or, with their `rate` in
    Hz, plain values.

    The degrees of freedom of each point are those of the kind of noise that dominates there by the
    fit of N, B, K and Q. Raises `ModelError` for a signal of under 64 values.

    `signal` is in its own unit, or plain values in `unit`.

    >>> import numpy
    >>> from proofmass import allan
    >>> rate = numpy.random.default_rng(1).standard_normal(20000)  # 0.1 deg/s/sqrt(Hz) at 100 Hz
    >>> answer = allan(rate, rate=100.0, unit="deg/s")
    >>> white = answer.levels.levels[0]
    >>> white.name, round(white.value, 2)
    ('N', 0.1)
    """
    series = as_series(signal, rate, unit)
    count = enough(series, FEWEST, "an Allan deviation")
    if not np.ptp(series.values) > 0.0:
        raise Problem(message="the signal does not move", key=series.name or "signal").error
    levels = fitted(series)
    x = integral(series)
    curves = {statistic: _curve(statistic, x, series.period, levels) for statistic in AllanStatistic}
    return Allan(series.name, series.unit, series.period, count, curves, levels)


def integral(series: Series) -> Array:
    """The running integral, in units of the signal times its period, one value more."""
    values = series.values - np.mean(series.values)
    return np.concatenate([[0.0], np.cumsum(values)])


def _curve(statistic: AllanStatistic, x: Array, period: float, levels: Levels) -> Curve:
    factors = _factors(statistic, len(x) - 1)
    taus = factors * period
    variances = np.array([variance(statistic, x, int(m)) for m in factors])
    kinds = dominating(levels, taus)
    degrees = np.array([freedom(statistic, len(x), int(m), a) for m, a in zip(factors, kinds, strict=True)])
    side = CONFIDENCE / 2.0
    low, high = (np.sqrt(variances * degrees / (2.0 * gammaincinv(0.5 * degrees, 0.5 + s))) for s in (side, -side))
    return Curve(statistic, taus, np.sqrt(variances), low, high, degrees)


def variance(statistic: AllanStatistic, x: Array, m: int) -> float:
    """The variance at an averaging time of m values, in units of the signal."""
    if statistic is AllanStatistic.HADAMARD:
        third = x[3 * m :] - 3.0 * x[2 * m : -m] + 3.0 * x[m : -2 * m] - x[: -3 * m]
        return float(np.mean(third**2)) / (6.0 * m * m)
    second = x[2 * m :] - 2.0 * x[m:-m] + x[: -2 * m]
    if statistic is AllanStatistic.MODIFIED:
        total = np.concatenate([[0.0], np.cumsum(second)])
        second = (total[m:] - total[:-m]) / m
    return float(np.mean(second**2)) / (2.0 * m * m)


def _factors(statistic: AllanStatistic, count: int) -> Any:
    """Numbers of values that are averaged, evenly on a logarithmic axis, as long as there are three places at least."""
    reach = {AllanStatistic.ALLAN: 2, AllanStatistic.HADAMARD: 3, AllanStatistic.MODIFIED: 3}[statistic]
    most = max(1, (count - 2) // reach)
    return np.unique(np.round(np.geomspace(1, most, 1 + int(PER_DECADE * np.log10(most)))).astype(int))


def dominating(levels: Levels, taus: Array) -> list[int]:
    """Return the exponent of frequency of the noise that has most of the Allan variance at each averaging time."""
    parts = allan_terms(taus) * np.array([level.value**2 for level in levels.levels])
    return [_ALPHA[NAMES[int(i)]] for i in np.argmax(parts, axis=1)]


@dataclass(frozen=True)
class Duration:
    """Length of a recording needed, and what the present length gives; times in seconds."""

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
    if not of.period * (1.0 - 1e-9) <= tau <= 0.25 * _MOST * of.period:
        expected = f"at least {of.period:g} s, from one value to the next, at most {0.25 * _MOST * of.period:g} s"
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
    if degrees(high) < wanted:
        hint = "ask for a larger error, or for a shorter averaging time"
        message = f"no recording of up to {_MOST:g} values is so accurate"
        raise Problem(message=message, key="confidence", got=f"{error:g}", hint=hint).error
    while high - low > max(1, factor // 100):
        middle = (low + high) // 2
        low, high = (low, middle) if degrees(middle) >= wanted else (middle, high)
    present = 1.0 / math.sqrt(2.0 * degrees(of.values)) if of.values > 2 * factor else None
    return Duration(factor * of.period, error, high * of.period, high, degrees(high), of.values * of.period, present)
