"""One table of what runs of a study were given: ages, times between calibrations, and every
parameter that varies.

Files, pictures and analyses of a study take their columns from here, with names, units and
dimensions. No two columns of a study have one name, measures included.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from proofmass.graphs.model.derived import measure_units
from proofmass.graphs.model.loops import MARGIN_MEASURES
from proofmass.graphs.studies.study import AGE, COLUMNS, EPOCH, RECALIBRATION, RUN, Study
from proofmass.runner.host.arrays import AnyArray

_ONE_BY_ONE = 20_000  # runs and epochs too few to compile the functions that draw


@dataclass(frozen=True)
class DrawnColumn:
    """Name and unit of a column, and what it differs with."""

    name: str  # as the study writes it, or another where something else has that name
    unit: str
    doc: str
    dimensions: tuple[str, ...]  # "run", "epoch" or both
    parameter: str = ""  # its name in the flat graph; "" for ages and intervals


def drawn_columns(study: Study) -> tuple[DrawnColumn, ...]:
    """Return the columns of a study: age, time between calibrations, then what is swept, spread or drifts."""
    columns = [DrawnColumn(AGE, "s", "Age of the sensor.", (EPOCH,))]
    if study.recalibration.carried:
        columns.append(DrawnColumn(RECALIBRATION, "s", "Time between calibrations.", (RUN,)))
    taken = _other_names(study)
    for parameter in dict.fromkeys([*study.sweep, *study.spread, *study.drift]):
        name = written if (written := study.name_of(parameter)) not in taken else parameter
        while name in taken:
            name = f"parameter.{name}"
        taken.add(name)
        ages = parameter in study.ageing
        doc, dimensions = ("Parameter at this age.", (RUN, EPOCH)) if ages else ("Parameter of the run.", (RUN,))
        columns.append(DrawnColumn(name, study.unit_of(parameter), doc, dimensions, parameter))
    return tuple(columns)


class DrawnTable:
    """The columns of some runs; `table[column]` has a row for each run and a column for each epoch.

    Parameters are without what calibrations leave. With `apart`, each is what it would be if
    nothing that it follows from were spread or drifted.
    """

    def __init__(self, study: Study, runs: AnyArray, *, apart: bool = False) -> None:
        self.study, self.runs, self.apart = study, runs, apart
        self.columns = drawn_columns(study)

    @property
    def parameters(self) -> tuple[DrawnColumn, ...]:
        """The columns of parameters and values."""
        return tuple(column for column in self.columns if column.parameter)

    def __getitem__(self, column: DrawnColumn) -> AnyArray:
        if column.parameter:
            return self._drawn[column.parameter].T
        shape = len(self.runs), len(self.study.epochs)
        if column.name == AGE:
            return np.broadcast_to(self.study.epochs, shape)
        intervals = np.array(self.study.recalibration.every)
        return np.broadcast_to(intervals[self.runs % len(intervals)][:, None], shape)

    def along(self, column: DrawnColumn) -> AnyArray:
        """Return a column along its own dimensions."""
        if column.dimensions == (EPOCH,):
            return np.array(self.study.epochs)
        return self[column] if EPOCH in column.dimensions else self[column][:, 0]

    @cached_property
    def _drawn(self) -> dict[str, AnyArray]:
        """Parameters by name in the flat graph, a row for each epoch."""
        if len(self.runs) * len(self.study.epochs) > _ONE_BY_ONE:
            # start-up time: only many runs need arrays of draws
            from proofmass.runner.studies.draws.drawing import drawn_together

            return drawn_together(self.study, self.runs, apart=self.apart)
        drawn = [self.study.drawn(run, apart=self.apart) for run in self.runs.tolist()]
        shape = len(self.study.epochs), len(drawn)
        names = [column.parameter for column in self.parameters]
        return {
            n: np.array([[at[n] for at in run] for run in drawn], dtype=float).reshape(shape[::-1]).T for n in names
        }


def _other_names(study: Study) -> set[str]:
    margins = {f"{loop}.{name}" for loop in study.flat.loops for name in MARGIN_MEASURES} if study.margins else ()
    return {*COLUMNS, *measure_units(study.flat), *margins, *study.changes}
