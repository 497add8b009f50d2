"""A signal sampled at equal steps: a column of a recording, or the trace of a probe."""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import Problem, did_you_mean, shown
from proofmass.blocks.declaration.unit_expressions import UnitError
from proofmass.blocks.declaration.units import convert
from proofmass.graphs.model.call_numbers import positive
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.recording import Column, RecordingError, read_columns
from proofmass.runner.run.result import Trace

_LEAST, _MOST = 1e-140, 1e140  # size of values whose squares, summed and divided, are still numbers
JITTER = 0.05  # of a step, by which the times of a recording may be off equal steps


def refused_scatter(values: Array, name: str) -> Problem | None:
    """Return why moving values are too large or small for their squares, or None, without NaN."""
    finite = np.isfinite(values)
    known = values if finite.all() else values[finite]  # no copy of many
    scatter = float(np.max(known)) - float(np.min(known)) if len(known) else 0.0
    if not scatter or _LEAST < scatter < _MOST:
        return None
    message = "the values are too large for their squares" if scatter > 1.0 else "the values are too small"
    expected, hint = f"{_LEAST:g} to {_MOST:g}", "give them in another unit"
    return Problem(message=message, key=name, got=f"{scatter:.3g}", expected=expected, hint=hint)


@dataclass(frozen=True, eq=False)
class Series:
    """Values at equal steps of time, in a unit.

    >>> import numpy
    >>> from proofmass import Series
    >>> series = Series(values=numpy.zeros(500), period=0.01, name="rate", unit="deg/s")
    >>> series.rate, series.duration, series.behind(1.0).values.shape
    (100.0, 5.0, (400,))
    """

    values: Array  # a row
    period: float  # seconds from value to value
    name: str = ""  # of the column
    unit: str = "1"  # of the values

    def __post_init__(self) -> None:
        """Refuse values whose squares are beyond the range of doubles."""
        problem = refused_scatter(self.values, self.name)
        if problem:
            raise problem.error

    @property
    def rate(self) -> float:
        """Values a second."""
        return 1.0 / self.period

    @property
    def duration(self) -> float:
        """Seconds."""
        return len(self.values) * self.period

    def behind(self, seconds: float) -> "Series":
        """The series without what lies before a time; raises `ModelError` where nothing is left."""
        first = max(0, math.ceil(seconds / self.period - 1e-9))
        if first >= len(self.values):
            message, length = "nothing is left of the signal", f"{self.duration:.6g} s of signal"
            raise Problem(message=message, key="skip", got=f"{seconds:.6g} s", expected=f"less than {length}").error
        return replace(self, values=self.values[first:])


def enough(series: Series, fewest: int, purpose: str) -> int:
    """Return the number of values of a series; raises `ModelError` where a purpose needs more, or one is not finite."""
    count, key = len(series.values), series.name or "signal"
    wrong = np.flatnonzero(~np.isfinite(series.values))
    if len(wrong):
        got = f"{series.values[wrong[0]]} in row {wrong[0]}" + f", and {len(wrong) - 1:,} more" * (len(wrong) > 1)
        raise Problem(message="all values must be finite", key=key, got=got, hint="leave it out, or cut there").error
    if count < fewest:
        raise Problem(
            message=f"the signal is too short for {purpose}",
            key=key,
            got=f"{count} values",
            expected=f"at least {fewest}",
            hint="run longer, or skip less",
        ).error
    return count


def as_series(source: Any, rate: float = 0.0, unit: str = "1") -> Series:
    """A series as it is, of a trace, or of plain values at a rate."""
    if isinstance(source, Series):
        return source
    if isinstance(source, Trace):
        return of_trace(source)
    if not positive(rate):
        expected = "a number above 0, in Hz"
        raise Problem(message="plain values need a rate", key="rate", got=shown(rate), expected=expected).error
    return Series(_row(source), 1.0 / rate, unit=unit)


def _row(source: Any) -> Array:
    """Return plain values as a row, NaN where they are masked; raises `ModelError` for anything but real numbers."""
    given = np.ma.asanyarray(source)
    if given.size != max(given.shape, default=0) or given.dtype.kind in "cmMV":
        got = f"{given.dtype} of shape {given.shape}"
        hint = "give one of its columns, values[:, 0]" if given.ndim > 1 else ""
        raise Problem(message="must be a row of real numbers", key="signal", got=got, hint=hint).error
    return np.asarray(np.ma.filled(given.astype(float), np.nan)).ravel()


def of_trace(trace: Trace, entry: int | None = None) -> Series:
    """The series of a probe, or of an entry of a vector; raises `ModelError` for a vector, or without that entry."""
    rows, count = trace.values.reshape(len(trace.values), -1), trace.entries
    if entry is None and trace.values.ndim > 1:
        message, hint = "is a vector, not one number", f"name one of its {count} entries, {trace.signal}[0]"
        hint += "; in Python give its values[:, 0] and their rate"
        raise Problem(message=message, key=trace.signal, hint=hint).error
    if not (entry or 0) < count:
        expected = f"an entry below {count}"
        raise Problem(message="has no such entry", key=trace.signal, got=f"[{entry}]", expected=expected).error
    name = trace.signal if entry is None else f"{trace.signal}[{entry}]"
    return Series(np.asarray(rows[:, entry or 0], dtype=float), float(trace.period), name, trace.unit)


def read_series(file: str | Path, column: str = "") -> Series:
    """A column of a CSV, Parquet or netCDF file, the first behind time where none is named; raises `ModelError`.

    `file` is a path, `column` the name of a column.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from proofmass import read_series
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder, "rate.csv")
    ...     _ = file.write_text("time [ms],rate [deg/s]\\n0,1\\n10,2\\n20,4\\n")
    ...     series = read_series(file, "rate")
    >>> series.unit, series.values.tolist(), series.rate
    ('deg/s', [1.0, 2.0, 4.0], 100.0)
    """
    path = Path(file)
    try:
        time, value = read_columns(path, lambda names: (0, _index(names, column)))
        return Series(np.array(value.values), _step(time), value.name, value.unit or "1")
    except RecordingError as error:
        key = column and error.parameter.removeprefix("file")  # a file that is wrong says nothing of a column
        raise Problem(message=str(error), file=str(path), line=error.line, key=key, hint=error.hint).error from None


def _index(names: Any, column: str) -> int:
    if len(names) < 2:
        raise RecordingError("needs a column of time and one of values")
    if column and column not in names[1:]:
        hint = did_you_mean(column, names[1:], "column")
        raise RecordingError(f"there is no column {column!r}", hint=hint, parameter="column")
    return int(names.index(column, 1)) if column else 1


def _step(time: Column) -> float:
    """Seconds from row to row; raises `RecordingError` where rows are missing or uneven."""
    try:
        times = np.array(time.values) * convert(f"1 {time.unit or 's'}", "s")
    except UnitError as error:
        raise RecordingError(f"column {time.name}: {error}", hint="its unit must be one of time") from None
    if len(times) < 2:
        raise RecordingError("holds one row")
    step = (times[-1] - times[0]) / (len(times) - 1)
    off = np.abs(times - (times[0] + step * np.arange(len(times))))
    worst = int(np.argmax(off))
    if not step > 0.0 or off[worst] > JITTER * step:
        raise RecordingError(
            f"its times are not equally spaced: row {worst + 1} is at {times[worst]:.9g} s, {off[worst]:.3g} s off a"
            f" step of {step:.6g} s",
            hint="a row may be missing; cut the recording there, or play it by a RecordedSignal at a rate of your own",
        )
    return float(step)
