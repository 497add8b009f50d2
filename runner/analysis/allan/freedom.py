"""Equivalent degrees of freedom of variances of differences (Greenhall and Riley, Proc. 35th PTTI, 2003, 267).

The estimate is a mean of squares of Gaussian numbers z[i]; with r the correlation of two of them,
for M places,

    1 / edf = (1 + 2 sum over j of (1 - j / M) r[j]^2) / M

r follows from the generalised autocovariance of the integral of the signal, a power of time or its
logarithm.
"""

from enum import StrEnum

import numpy as np

from proofmass.runner.host.arrays import Array

_PLACES = 20_000  # of a sum; a longer one is taken at fewer, evenly


class AllanStatistic(StrEnum):
    """A deviation over averaging time."""

    ALLAN = "allan"
    HADAMARD = "hadamard"
    MODIFIED = "modified"


def freedom(statistic: AllanStatistic, points: int, factor: int, alpha: int) -> float:
    """Degrees of freedom for so many points of the integral, values averaged, and density as f^alpha, -2 to 2."""
    order = 3 if statistic is AllanStatistic.HADAMARD else 2
    averaged = statistic is AllanStatistic.MODIFIED
    reach = order * factor + (factor if averaged else 1)
    places = max(1, points - reach + 1)
    longest = min(places - 1, (order + 1) * factor)
    step = max(1, longest // _PLACES)
    lags = np.arange(step, longest + 1, step) if longest else np.zeros(0)
    part = 1.0 if averaged else 0.0 if alpha <= 0 else 1.0 / factor
    own = _covariance(np.zeros(1), part, alpha, order)[0]
    others = _covariance(lags / factor, part, alpha, order) / own
    total = 1.0 + 2.0 * step * float(np.sum((1.0 - lags / places) * others**2))
    return max(1.0, places / total)


def _covariance(lag: Array, part: float, alpha: int, order: int) -> Array:
    """Covariance of two differences, but for a factor; `lag` and the `part` that is averaged in averaging times."""
    weights = {2: (6.0, -4.0, 1.0), 3: (20.0, -15.0, 6.0, -1.0)}[order]
    total = weights[0] * _mean(lag, part, alpha)
    for k, weight in enumerate(weights[1:], 1):
        total = total + weight * (_mean(lag - k, part, alpha) + _mean(lag + k, part, alpha))
    return np.asarray(total)


def _mean(lag: Array, part: float, alpha: int) -> Array:
    """Autocovariance of the integral of noise with a density as f^alpha, averaged over a part of an
    averaging time.

    White noise of the integral itself, alpha = 2, has none without: there it is averaged over one
    value.
    """
    if part == 0.0:
        return _power(lag, alpha + 2)
    return (2.0 * _power(lag, alpha) - _power(lag - part, alpha) - _power(lag + part, alpha)) / part**2


def _power(lag: Array, alpha: int) -> Array:
    """Its second integral, but for a factor: |t|^(3 - alpha), with a logarithm if that is even."""
    t = np.abs(lag)
    power = -(t ** (3 - alpha)) if alpha in (2, -1, -2) else t ** (3 - alpha)
    return np.asarray(power if alpha % 2 == 0 else power * np.log(np.where(t > 0.0, t, 1.0)))
