"""The epochs of a study: ages at which every sensor is looked at, and which of them calibrate it.

A calibration is a run like any other: what it measures becomes parameters of the later epochs,
until the next one. That is how the contents of registers outlive a run.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from proofmass.blocks.declaration.problem import Refusal, shown
from proofmass.graphs.studies.table_entries import read_time

NEVER = "never"
MOST_EPOCHS = 100_000
AGES_EXAMPLE = 'write ages = ["0 h", "1 year"], or every = "1 month" and until = "10 year"'
RECALIBRATION_EXAMPLE = 'write { every = "1 year", carried = { "gain.initial" = "gain_found" } }'
_SLACK = 1e-9  # of an interval, for ages that are rounded


@dataclass(frozen=True)
class Recalibration:
    """Times of calibrations, and the parameters that store measures of their runs.

    The first epoch always calibrates: it is the factory's. Each interval is a point that every
    sensor is tried at.
    """

    every: tuple[float, ...] = (math.inf,)  # seconds; infinite: never again
    carried: Mapping[str, str] = field(default_factory=lambda: MappingProxyType(dict[str, str]()))  # parameter: measure

    def at(self, ages: tuple[float, ...], interval: float) -> tuple[bool, ...]:
        """Per epoch, whether its run calibrates: the first, and each an interval or more after the last that did."""
        last, calibrated = -math.inf, list[bool]()
        for age in ages:
            due = bool(self.carried) and (not calibrated or age - last >= interval * (1.0 - _SLACK))
            last = age if due else last
            calibrated.append(due)
        return tuple(calibrated)

    def text(self) -> list[str]:
        """Return all that decides the bits of a run, a line each."""
        lines = [f"recalibration.carried.{name} = {measure}" for name, measure in sorted(self.carried.items())]
        return [f"recalibration.every = {list(self.every)}", *lines] if lines else []


def regular_ages(table: Mapping[str, Any]) -> tuple[float, ...]:
    """Ages from a new sensor on, in seconds: `{ every = "1 month", until = "10 year" }`; raises `Refusal`."""
    step, last = (read_time(table[key], key) for key in ("every", "until"))
    if step == 0 or last / step > MOST_EPOCHS:
        expected = f"above 0 s, and at most {MOST_EPOCHS:,} epochs in all"
        raise Refusal("out of range", key="every", got=shown(table["every"]), expected=expected)
    return tuple(float(number * step) for number in range(int(last / step) + 1))


def read_intervals(table: Mapping[str, Any]) -> tuple[float, ...]:
    """The intervals of a table `[recalibration]`, in seconds; raises `Refusal`."""
    example = 'write every = "1 year", or every = ["never", "1 year", "1 month"] to compare'
    every = table.get("every", ())
    intervals = [every] if isinstance(every, str | int | float) else every
    if not isinstance(intervals, list | tuple) or not intervals:
        raise Refusal("must say how often", key="every", got=shown(every), hint=example)
    read = [math.inf if entry == NEVER else float(read_time(entry, "every")) for entry in intervals]
    if min(read) <= 0.0 or len(set(read)) < len(read):
        raise Refusal("intervals must differ and be above 0 s", key="every", got=shown(every), hint=example)
    return tuple(read)
