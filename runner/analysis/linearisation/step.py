"""Step response of a linear map, and its figures: rise, settling, overshoot.

    x[n] = x_end - A^n x_end,   x_end = (I - A)^-1 B 1,   y = C x + D 1

is known for every period from the powers of A alone. The first 16,384 periods are all taken, those
after them ever wider apart, so that a time is known to a value of the output or to 1/8192 of
itself.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from proofmass.runner.analysis.linearisation.wire_response import WireResponse
from proofmass.runner.host.arrays import Array

RISE = (0.1, 0.9)  # of the final value
WITHIN = 0.02  # of the final value, in which a step has settled
_SHOWN, _FEWEST = 1.6, 16  # settling times that a picture shows, and values
_AT_ONCE, _PIECE = 1 << 14, 256  # periods
_MANY = 128  # states, from which zeros of delay lines count
_LEFT = math.log(1e8)  # by which the slowest mode has decayed at the end
_DECAY = 6.0  # times of the peak, the same where it comes back to zero
_NOTHING = 1e-9  # of the largest value: a final value that is rounding


@dataclass(frozen=True)
class StepFigures:
    """Figures of a step response; times in seconds, None where there are none."""

    final: float  # value of the output for a step of one
    rise: float | None  # from 10 % to 90 % of it
    settling: float | None  # from which on it stays within 2 % of it
    overshoot: float | None  # part of it by which it is passed
    undershoot: float | None  # part of it by which the output first goes the other way
    peak: float
    peak_time: float

    def as_data(self) -> dict[str, Any]:
        """The figures as plain data."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class StepResponse:
    """Times in seconds, values of the output for a step of one at 0 s, and the figures."""

    times: Array
    values: Array
    figures: StepFigures

    def shown(self) -> tuple[Array, Array]:
        """The part that a picture shows."""
        end = _SHOWN * (self.figures.settling or _DECAY * self.figures.peak_time)
        count = max(_FEWEST, int(np.searchsorted(self.times, end)))
        return self.times[:count], self.values[:count]


def step_response(of: WireResponse) -> StepResponse | None:
    """Return the response of the output to a step of the input; None where it does not settle."""
    if of.radius >= 1.0:
        return None
    times, values = _values(of)
    final = float(np.real(of.gain(np.zeros(1))[0]))
    return StepResponse(times, values, _figures(times, values, final))


def driven_step(of: WireResponse, periods: int) -> tuple[Array, Array]:
    """Return times and values of the output for a step of one over some periods, whether or not it settles."""
    a, b, c, d = of.matrices
    whole = np.eye(len(a) + 1)
    whole[:-1] = np.hstack([a, b.sum(axis=1, keepdims=True)])
    read = np.hstack([c, d.sum(axis=1, keepdims=True)])
    return _rows(of, whole, np.eye(len(whole))[-1], periods, lambda states: read @ states)


def _values(of: WireResponse) -> tuple[Array, Array]:
    a, b, c, d = of.matrices
    end = np.linalg.solve(np.eye(len(a)) - a, b.sum(axis=1)) if len(a) else np.zeros(0)
    last = c @ end + d.sum(axis=1)
    wanted = int(_LEFT / -math.log(of.radius)) + 2 * len(a) + 2 if of.radius > 0.0 else len(a) + 2
    return _rows(of, a, end, wanted, lambda errors: last[:, None] - c @ errors)


def _rows(of: WireResponse, a: Array, begin: Array, wanted: int, read: Callable[[Array], Array]) -> tuple[Array, Array]:
    """Return times and values that are read from A^n begin, for so many periods."""
    starts, rows = [], []
    for first, stride, columns in _powers(a, begin, wanted):
        starts.append(first + stride * np.arange(columns.shape[1]))
        rows.append(read(columns).T)
    times = of.late + np.add.outer(np.concatenate(starts), np.arange(of.values) / of.values) * of.period
    return times.ravel(), np.concatenate(rows).ravel()


def _powers(a: Array, begin: Array, wanted: int) -> Iterator[tuple[int, int, Array]]:
    """A^n begin: from a period on, at a stride, a column for each n."""
    sparse = len(a) > _MANY and 10 * np.count_nonzero(a) < a.size
    first, stride, power, column = 0, 1, csr_array(a) if sparse else a, begin
    while True:
        count = min(_AT_ONCE if first == 0 else _AT_ONCE // 2, -(-(wanted - first) // stride))
        for columns, following in (_stepped if sparse else _doubled)(column, power, count):
            yield first, stride, columns
            first, column = first + stride * columns.shape[1], following
        if first >= wanted:
            return
        power, stride = power @ power, 2 * stride


def _doubled(column: Array, power: Array, count: int) -> Iterator[tuple[Array, Array]]:
    """Yield so many columns, each the power times the one before, and the one behind them."""
    columns, jump = column[:, None], power
    while columns.shape[1] < count:
        columns, jump = np.hstack([columns, jump @ columns]), jump @ jump
    yield columns[:, :count], columns[:, count] if count < columns.shape[1] else jump @ columns[:, 0]


def _stepped(column: Array, power: Any, count: int) -> Iterator[tuple[Array, Array]]:
    """Yield them some at a time: with a power of many zeros a step takes less time than its part of a product."""
    for first in range(0, count, _PIECE):
        columns = np.empty((len(column), min(_PIECE, count - first)))
        for place in range(columns.shape[1]):
            columns[:, place], column = column, power @ column
        yield columns, column


def _figures(times: Array, values: Array, final: float) -> StepFigures:
    at = int(np.argmax(np.abs(values)))
    if abs(final) <= _NOTHING * abs(float(values[at])):
        return StepFigures(0.0, None, None, None, None, float(values[at]), float(times[at]))
    part = values / final
    highest = int(np.argmax(part))
    low, high = (_reached(times, part, share) for share in RISE)
    return StepFigures(
        final,
        None if low is None or high is None else high - low,
        _stays(times, part),
        max(float(part[highest]) - 1.0, 0.0),
        max(0.0, -float(np.min(part))),
        float(values[highest]),
        float(times[highest]),
    )


def _reached(times: Array, part: Array, share: float) -> float | None:
    """Return when a share of the final value is first reached, on a line between two values."""
    above = np.flatnonzero(part >= share)
    return _crossed(times, part, int(above[0]), share) if len(above) else None


def _stays(times: Array, part: Array) -> float | None:
    """Return from when on the output stays near its final value."""
    outside = np.flatnonzero(np.abs(part - 1.0) > WITHIN)
    if not len(outside):
        return float(times[0])
    last = int(outside[-1])
    if last + 1 == len(part):
        return None
    return _crossed(times, part, last + 1, 1.0 + math.copysign(WITHIN, float(part[last]) - 1.0))


def _crossed(times: Array, part: Array, after: int, level: float) -> float:
    if after == 0:
        return float(times[0])
    before, now = float(part[after - 1]), float(part[after])
    share = (level - before) / (now - before)
    return float(times[after - 1] + share * (times[after] - times[after - 1]))
