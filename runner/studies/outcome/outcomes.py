"""Outcomes of the runs of a study, in columns: a number for each run, epoch and measure."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from proofmass.runner.host.arrays import AnyArray


class SensorRun(NamedTuple):
    """Outcome of one run at one epoch: values of the measures in the order of their names, or why it failed."""

    run: int
    epoch: int
    values: tuple[float, ...] | None
    fault: str = ""


class Outcomes(NamedTuple):
    """Outcomes of runs at all epochs; failed ones have NaN, and their reason among the faults."""

    numbers: AnyArray  # of the runs, in any order
    values: AnyArray  # by run, epoch and measure
    faults: dict[tuple[int, int], str]  # by run number and epoch

    def chosen(self, which: AnyArray) -> "Outcomes":
        """Return some of the runs, by a mask or by places."""
        numbers = self.numbers[which]
        left = set(numbers.tolist()) if self.faults else set()
        return Outcomes(numbers, self.values[which], {key: text for key, text in self.faults.items() if key[0] in left})

    def stretches(self) -> Iterator["Outcomes"]:
        """Yield the runs in stretches of consecutive numbers, in their order."""
        ordered = self.chosen(np.argsort(self.numbers, kind="stable"))
        cuts = np.flatnonzero(np.diff(ordered.numbers) != 1) + 1
        for first, last in zip([0, *cuts.tolist()], [*cuts.tolist(), len(ordered.numbers)], strict=True):
            if last > first:
                yield ordered.chosen(np.arange(first, last))


def outcomes_of(runs: Iterable[SensorRun], epochs: int, measures: int) -> Outcomes:
    """Return the outcomes of runs that come one after the other, each with its epochs in order."""
    numbers, rows, faults = list[int](), list[Sequence[float]](), dict[tuple[int, int], str]()
    for run in runs:
        if run.epoch == 0:
            numbers.append(run.run)
        rows.append((math.nan,) * measures if run.values is None else run.values)
        if run.fault:
            faults[run.run, run.epoch] = run.fault
    table = np.array(rows, dtype=float).reshape(len(numbers), epochs, measures)
    return Outcomes(np.array(numbers, dtype=np.int64), table, faults)


def together(parts: Sequence[Outcomes], epochs: int, measures: int) -> Outcomes:
    """Return several outcomes as one."""
    if len(parts) == 1:
        return parts[0]
    faults = {key: text for part in parts for key, text in part.faults.items()}
    numbers = [np.empty(0, dtype=np.int64), *(part.numbers for part in parts)]
    values = [np.empty((0, epochs, measures)), *(part.values for part in parts)]
    return Outcomes(np.concatenate(numbers), np.concatenate(values), faults)
