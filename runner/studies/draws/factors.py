"""Factors that may explain a measure at an epoch: the parameters of the runs, and how far they have drifted.

With x(e) a parameter at an epoch and c the last epoch before e that calibrated (the first one where
none has since):

    x(c)           what it was then; named as the parameter
    x(e) - x(c)    its change since then, of a drifting parameter; named "change of" the parameter

A calibrated sensor depends on the changes alone: the calibration has removed the effect of earlier
values.

Of a parameter that follows a formula and has a spread or drift of its own, x is the part that is
its own: what the parameter would be if nothing that it follows from were spread or drifted. So what
several parameters follow from is one factor, and what each adds to it is another.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from proofmass.graphs.studies.study import Study
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.studies.draws.drawn_table import DrawnTable

CHANGE = "change of "
_ROUNDINGS = 2.0**-50  # of a value, relative: a change that is the same for all sensors differs by so much


@dataclass(frozen=True)
class Factors:
    """Values of factors at one epoch by name, a number for each run, and their units."""

    columns: Mapping[str, AnyArray]
    units: Mapping[str, str]


class Drawn:
    """Factors of runs of a study at all epochs, drawn once."""

    def __init__(self, study: Study, runs: AnyArray) -> None:
        self.study, self.runs = study, runs
        self.table = DrawnTable(study, runs, apart=True)

    def factors(self, epoch: int) -> Factors:
        """Return the factors at an epoch that differ between runs."""
        since = self.since(epoch)
        columns, units = dict[str, AnyArray](), dict[str, str]()
        for name, unit, values, rounding in self._columns(epoch, since):
            if values.size and np.ptp(values) > rounding:
                columns[name], units[name] = values, unit
        return Factors(columns, units)

    def since(self, epoch: int) -> AnyArray:
        """Return for each run the last epoch before this one that calibrated; the first epoch if none did."""
        intervals = len(self.study.recalibration.every)
        lasts = []
        for number in range(intervals):
            calibrated = self.study.calibrated(number)
            lasts.append(max((before for before in range(epoch) if calibrated[before]), default=0))
        return np.asarray(np.array(lasts)[self.runs % intervals])

    def _columns(self, epoch: int, since: AnyArray) -> Iterator[tuple[str, str, AnyArray, float]]:
        for column in self.table.parameters:
            values = self.table[column]
            before = values[np.arange(len(self.runs)), since]
            yield column.name, column.unit, before, 0.0
            if column.parameter in self.study.drift:
                rounding = _ROUNDINGS * float(np.max(np.abs(values[:, epoch]), initial=0.0))
                yield CHANGE + column.name, column.unit, values[:, epoch] - before, rounding
