"""Factors that may explain a measure at an epoch: the parameters of the runs, and how far they have drifted.

With x(e) a parameter at an epoch and c the last epoch before e that calibrated (the first one where none has since):

    x(c)           what it was then; named as the parameter
    x(e) - x(c)    its change since then, of a parameter that drifts; named "change of" the parameter

A calibrated sensor depends on the changes alone: the calibration has removed the effect of earlier values.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from proofmass.graphs.studies.study import Study
from proofmass.runner.run.result import Array

CHANGE = "change of "
_ONE_BY_ONE = 20_000  # runs and epochs up to which compiling the functions that draw them is not worth it


@dataclass(frozen=True)
class Factors:
    """Values of factors at one epoch by name, a number for each run, and their units."""

    columns: Mapping[str, Array]
    units: Mapping[str, str]


class Drawn:
    """Parameters of runs of a study at all epochs, drawn once."""

    def __init__(self, study: Study, runs: Array) -> None:
        self.study, self.runs = study, runs
        self.parameters = parameters_of(study, runs)

    def factors(self, epoch: int) -> Factors:
        """Return the factors at an epoch that differ between runs."""
        since = self.since(epoch)
        columns, units = dict[str, Array](), dict[str, str]()
        for name, values, change in self._columns(epoch, since):
            if values.size and np.ptp(values) > 0.0:
                label = CHANGE * change + self.study.name_of(name)
                columns[label], units[label] = values, self.study.unit_of(name)
        return Factors(columns, units)

    def since(self, epoch: int) -> Array:
        """Return for each run the last epoch before this one that calibrated; the first epoch if none did."""
        intervals = len(self.study.recalibration.every)
        lasts = []
        for number in range(intervals):
            calibrated = self.study.calibrated(number)
            lasts.append(max((before for before in range(epoch) if calibrated[before]), default=0))
        return np.asarray(np.array(lasts)[self.runs % intervals])

    def _columns(self, epoch: int, since: Array) -> Iterator[tuple[str, Array, bool]]:
        for name, rows in self.parameters.items():
            before = rows[since, np.arange(len(self.runs))]
            yield name, before, False
            if name in self.study.drift:
                yield name, rows[epoch] - before, True


def parameters_of(study: Study, runs: Array) -> dict[str, Array]:
    """Return parameters of runs by name in the flat graph, a row for each epoch, without calibrated values."""
    if len(runs) * len(study.epochs) > _ONE_BY_ONE:
        # start-up time: only influences need arrays of draws
        from proofmass.runner.studies.draws.drawing import drawn_together

        return drawn_together(study, runs)
    drawn = [study.drawn(int(run)) for run in runs]
    names = drawn[0][0] if drawn else ()
    return {name: np.array([[at[name] for at in run] for run in drawn], dtype=float).T for name in names}
