"""Reader of studies: tables of a study file become a Study, or a list of all their faults."""

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

from proofmass.blocks.declaration.parameter import plain
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.checks.check import checked
from proofmass.graphs.model.graph import NOWHERE, Graph, Place
from proofmass.graphs.studies.ageing import read_drift
from proofmass.graphs.studies.distributions import read_spread
from proofmass.graphs.studies.missions import read_mission
from proofmass.graphs.studies.study import Study as Value
from proofmass.graphs.studies.study import bad_numbers
from proofmass.graphs.studies.study_tables import StudyTables
from proofmass.graphs.studies.table_entries import read_quantity, read_values

PlainTables = Mapping[str, Any]
NOTHING: PlainTables = MappingProxyType({})


class Study(Value):
    """A graph with the spread, sweep and drift of its parameters; run k is a pure function of it, seed and k.

    The tables are those of a study file: `spread={"adc.reference": {"normal": "200 ppm",
    "relative": True}}`. Run k is sensor k // n at point k % n of the sweep's n: every point is
    tried with the same sensors. Each run is repeated at each epoch, an age at which its drifting
    parameters have moved on, with what calibrations before it have left. `design` is one of
    `DESIGNS`.

    Raises `ModelError` with every problem.

    `graph` has measures. `runs` is the number of sensors, `seed` that of all draws, `epochs` are
    the ages. `spread`, `correlation`, `sweep`, `drift`, `missions`, `recalibration`, `margins`,
    `changes`, `limits` and `stop` are as in a file. `place` is the file that a study comes from.

    >>> from proofmass import Study, read_graph, run_study
    >>> graph = read_graph("library:scale_factor_drift")
    >>> study = Study(graph=graph, runs=3, spread={"torquer.gain": {"normal": "200 ppm", "relative": True}})
    >>> run_study(study)["scale_factor"].shape  # three sensors, all of one age
    (3, 1)
    """

    def __init__(
        self,
        graph: Graph,
        *,
        runs: int = 100,
        seed: int = 0,
        design: str = "random",
        spread: PlainTables = NOTHING,
        correlation: PlainTables = NOTHING,
        sweep: PlainTables = NOTHING,
        epochs: PlainTables = NOTHING,
        drift: PlainTables = NOTHING,
        recalibration: PlainTables = NOTHING,
        margins: str | float = "",
        missions: PlainTables = NOTHING,
        changes: PlainTables = NOTHING,
        limits: PlainTables = NOTHING,
        stop: PlainTables = NOTHING,
        place: Place = NOWHERE,
    ) -> None:
        read = StudyTables(checked(graph), margins)
        folder = (place if place is not NOWHERE else graph.place).folder
        spreads = read.parameters("spread", spread, lambda entry, unit: read_spread(entry, unit, folder))
        ages = read.ages(epochs)
        histories = read.read("missions", missions, lambda name, entry: read_mission(entry, folder))
        calibrations = read.recalibration(recalibration)
        changed = read.changes(changes, ages, bool(calibrations.carried))
        super().__init__(
            graph=graph,
            runs=plain(runs),
            seed=plain(seed),
            design=read.design(design, spreads),
            spread=spreads,
            correlation=read.correlation(correlation, spreads, design),
            sweep=read.parameters("sweep", sweep, lambda values, unit: read_values(values, "", unit)),
            epochs=ages,
            drift=read.parameters("drift", drift, lambda entry, unit: read_drift(entry, unit, histories)),
            recalibration=calibrations,
            margins=read.margins,
            changes=changed,
            limits=read.read("limits", limits, lambda name, entry: read.limit(name, entry, ages)),
            stop=read.read("stop", stop, lambda name, entry: read_quantity({name: entry}, name, read.unit(name), 0.0)),
            written=MappingProxyType(read.written),
            place=place,
        )
        problems = [*read.problems, *bad_numbers(self), *_moved_twice(self)]
        if problems:
            raise ModelError([self.placed(problem) for problem in problems])


def _moved_twice(study: Value) -> Iterator[Problem]:
    for name in study.recalibration.carried:
        for table in ("spread", "sweep", "drift"):
            if name in getattr(study, table):
                message = "a calibration sets it: nothing else can move it"
                yield Problem(message=message, key=f'{table}."{name}"', path=(table, name))
