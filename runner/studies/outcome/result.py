"""The outcome of a study: every measure of every sensor at every epoch, statistics and yield."""

import hashlib
import math
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from proofmass.blocks.declaration.libraries import need
from proofmass.blocks.declaration.problem import Problem
from proofmass.blocks.declaration.shown_units import display, in_table, long_time, prefix
from proofmass.graphs.studies.study import RUN, Study
from proofmass.runner.host.arrays import AnyArray, read_only
from proofmass.runner.host.notebook import Plotted, html_table
from proofmass.runner.plan.planned import PlannedMeasure
from proofmass.runner.studies.draws.drawn_table import DrawnTable
from proofmass.runner.studies.outcome.intervals import (
    Bounds,
    deviation_interval,
    mean_interval,
    part_interval,
    percentile_interval,
)
from proofmass.runner.studies.outcome.outcomes import Outcomes

if TYPE_CHECKING:
    import pandas
    import xarray

PERCENTILES = (1.0, 50.0, 99.0)


@dataclass(frozen=True, eq=False, repr=False)
class StudyResult(Plotted):
    """A finished or interrupted study; `result["bias"]` has a row per run that is done and a column per epoch.

    >>> from proofmass import read_study, run_study
    >>> result = run_study(read_study("library:scale_factor_drift"), runs=4)
    >>> result.interrupted, sorted(result.yields())
    (False, ['all limits', 'noise', 'scale_factor'])
    """

    study: Study  # that ran
    measures: tuple[PlannedMeasure, ...]  # with their units
    numbers: AnyArray  # of the runs that are done, read-only
    values: Mapping[str, AnyArray]  # by measure, read-only, a row per run and a column per epoch
    faults: Mapping[tuple[int, int], str]  # by run and epoch
    planned_runs: int  # after which the study ends
    seconds: float  # wall time
    engine: str  # that ran
    provenance: Mapping[str, str] = field(default_factory=dict)  # versions, machine and date
    lost_workers: tuple[str, ...] = ()  # of Dask, by address: others did their runs
    noted: Callable[[], Iterable[Problem]] = field(default=tuple, repr=False, compare=False)  # gives the notes

    def __post_init__(self) -> None:
        object.__setattr__(self, "numbers", read_only(self.numbers))
        object.__setattr__(self, "values", {name: read_only(values) for name, values in self.values.items()})

    def __getitem__(self, measure: str) -> AnyArray:
        return self.values[measure]

    def __repr__(self) -> str:
        runs = f"{len(self.numbers):,} of {self.planned_runs:,} runs"
        epochs = f" at {len(self.study.epochs)} epochs" if len(self.study.epochs) > 1 else ""
        failed = f", {len(self.faults):,} failed" if self.faults else ""
        return f"<StudyResult of {self.study.graph.name}: {runs}{epochs}{failed}; {', '.join(self.values)}>"

    def unit_of(self, name: str) -> str | None:
        """Return the unit of a measure; None for one that the study does not have."""
        return next((measure.unit for measure in self.measures if measure.name == name), None)

    @property
    def interrupted(self) -> bool:
        """True if runs are missing, since the study was interrupted."""
        return len(self.numbers) < self.planned_runs

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """On ages, correlations and limits, and on blocks at a corner about which loops are linearised."""
        return tuple(map(str, self.noted()))

    @cached_property
    def sensors(self) -> int:
        """Number of sensors that are independent, since every point has the same ones; a group of Saltelli's is one."""
        return len(self.draws)

    @cached_property
    def draws(self) -> AnyArray:
        """Numbers of the sensors that are independent, in their order."""
        return np.unique(self.study.draw(self.numbers))

    def of_draws(self, values: AnyArray) -> AnyArray:
        """Return for each of `draws` the mean of values of its runs: how means, yields and intervals count.

        Runs without a value do not count; NaN where no run has one. Columns stay apart.
        """
        known, places = np.isfinite(values), np.searchsorted(self.draws, self.study.draw(self.numbers))
        sums = np.zeros((2, len(self.draws), *values.shape[1:]))
        np.add.at(sums[0], places, np.where(known, values, 0.0))
        np.add.at(sums[1], places, known)
        with np.errstate(invalid="ignore"):
            return np.asarray(sums[0] / sums[1])

    @cached_property
    def digest(self) -> str:
        """SHA-256 over all values in the order of runs, epochs and names: equal if every bit is."""
        digest = hashlib.sha256()
        for name in sorted(self.values):
            digest.update(np.ascontiguousarray(self.values[name], dtype="<f8").tobytes())
        return digest.hexdigest()

    def good(self) -> AnyArray | None:
        """Return for each run whether it keeps all limits at all epochs; None without limits."""
        if not self.study.limits:
            return None
        return np.asarray(np.logical_and.reduce([self.kept(name) for name in self.study.limits]))

    def kept(self, name: str) -> AnyArray:
        """Return for each run whether it keeps a limit at all epochs that count for it."""
        return np.asarray(self.within(name).all(axis=1))

    def within(self, name: str) -> AnyArray:
        """Return by run and epoch whether a limit is kept; true at epochs that do not count."""
        limit, values = self.study.limits[name], self.values[name]
        first = limit.counted(self.study.epochs)
        good = (values >= limit.at_least) & (values <= limit.at_most)
        if math.isfinite(limit.change):
            reference = values[:, first : first + 1]
            good &= np.abs(values - reference) <= limit.change * np.abs(reference)
        good[:, :first] = True
        return np.asarray(good)

    def summary(self) -> list[dict[str, Any]]:
        """Return runs, mean, std (n - 1), extremes and percentiles by measure and epoch, without failed runs.

        `intervals` are those of mean, std and percentiles at 95 %, with infinite ends where runs
        are too few. Several points have the same sensors, and groups of Saltelli's design the same
        noise: mean and its interval count each once, the other intervals have no ends.
        """
        return [dict(row) for row in self._summary]

    @cached_property
    def _summary(self) -> list[dict[str, Any]]:
        rows = []
        for measure in self.measures:
            for epoch, age in enumerate(self.study.epochs):
                column = self.values[measure.name][:, epoch]
                values = column[np.isfinite(column)]
                row: dict[str, Any] = {"measure": measure.name, "unit": measure.unit, "age_s": age, "runs": len(values)}
                if len(values):
                    of_draws = self.of_draws(column)
                    mean = float(of_draws[np.isfinite(of_draws)].mean())
                    row |= {"mean": mean, "min": float(values.min()), "max": float(values.max())}
                    row["std"] = float(values.std(ddof=1)) if len(values) > 1 else 0.0
                    found = np.percentile(values, PERCENTILES)
                    row |= {f"p{p:g}": float(v) for p, v in zip(PERCENTILES, found, strict=True)}
                    row["intervals"] = self._intervals(measure.name, epoch, values)
                rows.append(row)
        return rows

    def _intervals(self, measure: str, epoch: int, values: AnyArray) -> dict[str, Bounds]:
        """Return the intervals of a measure at an epoch; `values` are the finite ones."""
        if len(self.numbers) > self.sensors:
            nothing = dict.fromkeys((f"p{p:g}" for p in PERCENTILES), (-math.inf, math.inf))
            return {"mean": self.mean_of_sensors(self.values[measure][:, epoch]), "std": (0.0, math.inf), **nothing}
        intervals = {"mean": mean_interval(values), "std": deviation_interval(values)}
        return intervals | {f"p{p:g}": percentile_interval(values, p) for p in PERCENTILES}

    def mean_of_sensors(self, values: AnyArray) -> Bounds:
        """Return the interval of the mean of values of the runs: each draw counts once, with the mean of its runs."""
        of_draws = self.of_draws(values)
        return mean_interval(of_draws[np.isfinite(of_draws)])

    def yield_intervals(self) -> dict[str, Bounds]:
        """Return confidence intervals of the yields, of as many runs as sensors."""
        return {name: part_interval(part * self.sensors, self.sensors) for name, part in self.yields().items()}

    def yields(self) -> dict[str, float]:
        """Return the fractions of sensors within each limit at all epochs, and within all."""
        good = self.good()
        if good is None or not len(good):
            return {}
        each = {name: self.kept(name) for name in self.study.limits} | {"all limits": good}
        return {name: float(self.of_draws(kept).mean()) for name, kept in each.items()}

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a row for each run and epoch: its age in seconds, the parameters that differ, and the measures."""
        need("pandas", "xarray")
        frame = self.to_xarray().to_dataframe().reset_index()
        return frame

    def _repr_html_(self) -> str:
        heads = ("measure", "unit", "age", "runs", "mean", "std", "p1", "p50", "p99")
        rows = []
        for row in as_shown(self).summary():
            numbers = [f"{row[key]:.6g}" if key in row else "" for key in heads[4:]]
            age = long_time(row["age_s"]) if row["age_s"] >= 3600.0 else f"{row['age_s']:g} s"
            rows.append([row["measure"], in_table(row["unit"]), age, row["runs"], *numbers])
        below = [f"yield, {name}: {100.0 * part:.2f} %" for name, part in self.yields().items()]
        return html_table(heads, rows, repr(self)[1:-1], below)

    def to_xarray(self) -> "xarray.Dataset":
        """Return a Dataset over run and epoch: a variable for each measure, the parameters of the
        runs as coordinates.

        A parameter that drifts, or follows from one that does, has a value for each run and epoch,
        any other one for each run.
        """
        need("xarray")
        # start-up time: xarray takes 0.4 s
        import xarray

        table = DrawnTable(self.study, self.numbers)
        coordinates: dict[str, Any] = {RUN: self.numbers}
        for column in table.columns:
            about = {"units": column.unit, "long_name": column.doc}
            coordinates[column.name] = (column.dimensions, table.along(column), about)
        about_measures = {m.name: {"units": m.unit, "long_name": f"{m.statistic} of {m.signal}"} for m in self.measures}
        variables = {name: (("run", "epoch"), values, about_measures[name]) for name, values in self.values.items()}
        return xarray.Dataset(variables, coordinates, self.attributes())

    def some(self, chosen: AnyArray, parts: int = 1) -> "StudyResult":
        """Return some of the runs, by a mask; they are one of so many parts of the study."""
        numbers = self.numbers[chosen]
        left = set(numbers.tolist())
        return replace(
            self,
            numbers=numbers,
            values={name: values[chosen] for name, values in self.values.items()},
            faults={key: fault for key, fault in self.faults.items() if key[0] in left},
            planned_runs=self.planned_runs // parts,
        )

    def attributes(self) -> dict[str, str]:
        """Return graph, seed and versions behind the numbers."""
        own = {"graph": self.study.graph.name, "study": self.study.text(), "digest": self.digest}
        return own | dict(self.provenance)


def as_shown(result: StudyResult, beside: Collection[StudyResult] = ()) -> StudyResult:
    """Return a study in units for people: what its measures ask for, such as deg/h, or with a
    prefix that suits them, and those of the same name and unit in studies `beside` it.

    The digest of what it returns is not that of the study.
    """
    units = {measure.name: _shown_unit(measure, (result, *beside)) for measure in result.measures}
    factors = {name: factor for name, (factor, _) in units.items() if factor != 1.0}
    if not factors:
        return result
    limits = dict(result.study.limits)
    for name in limits.keys() & factors.keys():
        limit, factor = limits[name], factors[name]
        limits[name] = replace(limit, at_least=limit.at_least * factor, at_most=limit.at_most * factor)
    return replace(
        result,
        study=result.study.with_limits(limits),
        measures=tuple(replace(measure, unit=units[measure.name][1], shown_in="") for measure in result.measures),
        values={name: rows * factors[name] if name in factors else rows for name, rows in result.values.items()},
    )


def _shown_unit(measure: PlannedMeasure, results: Collection[StudyResult]) -> tuple[float, str]:
    """Return the factor and the unit in which a measure is shown: a prefix only where numbers are long without it."""
    if measure.shown_in:
        return display(measure.unit, measure.shown_in, 1.0)[0], measure.shown_in
    alike = [result.values[measure.name] for result in results if result.unit_of(measure.name) == measure.unit]
    largest = max(float(np.max(np.abs(values), where=np.isfinite(values), initial=0.0)) for values in alike)
    return (1.0, measure.unit) if 0.01 <= largest < 1e4 else prefix(measure.unit, largest)


def collected(measures: tuple[PlannedMeasure, ...], outcomes: Outcomes) -> dict[str, Any]:
    """Return numbers, values and faults of runs as fields of a result."""
    values = {measure.name: outcomes.values[:, :, i] for i, measure in enumerate(measures)}
    return {"numbers": outcomes.numbers, "values": values, "faults": outcomes.faults}
