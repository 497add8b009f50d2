"""Recorded source: output = the recorded value of the last recorded time <= t, or the straight line to the next.

Before the first recorded time the first value, after the last one the last value.
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Recording, param
from proofmass.blocks.sources.piecewise_constant import index_at


class RecordedSignal(Block):
    """A signal from a file: measured noise, a temperature log, the output of another program."""

    file: str = param("", "CSV, Parquet or netCDF file; its first column is time in seconds.", default="")
    column: str = param("", "Column to play; empty for the first after time.", default="")
    interpolated: bool = param("1", "Straight lines between the recorded values, not steps.", default=False)
    unit: str = param("", "Unit of the output.", default="1")

    times = Recording("time", "Recorded times.")
    values = Recording("value", "Recorded values.")


class State(NamedTuple):
    entry: int


class Constants(NamedTuple):
    interpolated: bool
    slack: float


@RecordedSignal.constants
def constants(p: RecordedSignal, period: float) -> Constants:
    return Constants(p.interpolated, 1.0e-3 * period)  # a recorded time of few digits still falls on its tick


@RecordedSignal.output("{unit}")
def output(c: Constants, x: State, times: list[float], values: list[float], time: float) -> float:
    """The recorded value."""
    i = index_at(time if c.interpolated else time + c.slack, x.entry, times)
    if not c.interpolated or i + 1 >= len(times) or time <= times[i]:
        return values[i]
    part = (time - times[i]) / (times[i + 1] - times[i])
    return values[i] + part * (values[i + 1] - values[i])


@RecordedSignal.update
def update(c: Constants, x: State, times: list[float], time: float) -> State:
    return State(index_at(time if c.interpolated else time + c.slack, x.entry, times))
