"""Recordings that a graph is compared with, and what is done about gaps, missing values and the first time.

Times must ascend. They are counted from the first row. A value that is missing in an output is not
compared; one that is missing in an input is refused. A gap, more than one and a half steps long, is
refused unless the recording is to be cut there: the pieces then run one by one, each from rest.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np

from proofmass.blocks.declaration.problem import Problem, Refusal
from proofmass.blocks.declaration.units import convert_exactly, same_dimension
from proofmass.runner.analysis.spectrum.series import refused_scatter
from proofmass.runner.design.identification.tables import (
    RecordedTable,
    read_table_file,
    table_of_arrays,
    table_of_dataset,
)
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.output.counts import count

GAP = 1.5  # steps
FEWEST = 8  # rows of a piece
_NAMED = 3  # gaps in a message
Gaps = Literal["refuse", "split"]


@dataclass(frozen=True)
class RecordedStretch:
    """One stretch of recorded signals, in the units of the graph: times from 0, inputs and outputs by signal."""

    source: str
    times: AnyArray
    inputs: Mapping[str, AnyArray]
    outputs: Mapping[str, AnyArray]

    @property
    def duration(self) -> float:
        """Seconds from the first row to the last."""
        return float(self.times[-1])

    @property
    def rate(self) -> float:
        """Rows a second."""
        return (len(self.times) - 1) / self.duration


@dataclass(frozen=True)
class Wanted:
    """A signal of the graph and the column that holds it."""

    signal: str
    column: str
    unit: str


def recordings_of(
    data: object, inputs: Sequence[Wanted], outputs: Sequence[Wanted], gaps: Gaps
) -> tuple[list[RecordedStretch], list[str]]:
    """Return recordings of files, tables of arrays or xarray datasets, and remarks about them.

    A table of arrays has the times under "time", or under its first name. Raises `ModelError`.
    """
    sources = list(data) if isinstance(data, list | tuple) else [data]
    stretches, notes = list[RecordedStretch](), list[str]()
    for number, source in enumerate(sources, 1):
        table = _table(source, [w.column for w in (*inputs, *outputs)], f"recording {number}")
        notes += [f"{table.source}: {note}" for note in table.notes]
        made, said = _stretches(table, inputs, outputs, gaps)
        stretches += made
        notes += [f"{table.source}: {note}" for note in said]
    return stretches, notes


def _table(source: Any, wanted: list[str], name: str) -> RecordedTable:
    if isinstance(source, str | Path):
        return read_table_file(Path(source), wanted)
    if isinstance(source, RecordedTable):
        return source
    if hasattr(source, "data_vars"):
        return table_of_dataset(source, wanted, name)
    if not isinstance(source, Mapping) or not source:
        message, hint = "is not a recording", 'give a file, or {"time": times, "force": values, ...}'
        raise Problem(message=message, key=name, got=type(source).__name__, hint=hint).error
    return table_of_arrays(source, name)


def _stretches(
    table: RecordedTable, inputs: Sequence[Wanted], outputs: Sequence[Wanted], gaps: Gaps
) -> tuple[list[RecordedStretch], list[str]]:
    notes = list[str]()
    first = next(iter(table.columns))
    times = _converted(table, first, "s")
    _refuse_times(table.source, first, times)
    played = {w.signal: _converted(table, w.column, w.unit) for w in inputs}
    measured = {w.signal: _converted(table, w.column, w.unit) for w in outputs}
    for wanted in inputs:
        missing = np.flatnonzero(~np.isfinite(played[wanted.signal]))
        if len(missing):
            message = f"the input {wanted.column} misses {len(missing)} of {len(times)} values"
            got, hint = f"the first in row {missing[0] + 1}", "an input must be known at all times: fill the values in"
            raise Problem(message=message, file=table.source, key=wanted.column, got=got, hint=hint).error
    for wanted in outputs:
        missing = np.flatnonzero(~np.isfinite(measured[wanted.signal]))
        if len(missing) == len(times):
            raise Problem(message="holds no values", file=table.source, key=wanted.column).error
        if len(missing):
            notes.append(f"{len(missing)} of {len(times)} values of {wanted.column} are missing and are not compared")
        beyond = refused_scatter(measured[wanted.signal], wanted.column)
        if beyond:
            raise replace(beyond, file=table.source).error
    if times[0]:
        notes.append(f"starts at {times[0]:.6g} s, which is taken for 0")
    step = float(np.median(np.diff(times)))
    cuts = np.flatnonzero(np.diff(times) > GAP * step)
    if len(cuts) and gaps == "refuse":
        some = ", ".join(f"{times[i]:.6g} s to {times[i + 1]:.6g} s" for i in cuts[:_NAMED])
        more = f", and {len(cuts) - _NAMED} more" if len(cuts) > _NAMED else ""
        message, hint = f"has {count(len(cuts), 'gap')}", "--gaps split runs the pieces one by one, each from rest"
        expected = f"steps of at most {GAP * step:.6g} s"
        problem = Problem(message=message, file=table.source, key=first, got=some + more, expected=expected, hint=hint)
        raise problem.error
    ends = [0, *(int(i) + 1 for i in cuts), len(times)]
    stretches = []
    for low, high in pairwise(ends):
        if high - low < FEWEST:
            notes.append(f"a piece of {high - low} rows at {times[low]:.6g} s is left out")
            continue
        inside = slice(low, high)
        cut = ({signal: values[inside] for signal, values in of.items()} for of in (played, measured))
        stretches.append(RecordedStretch(table.source, times[inside] - times[low], *cut))
    if not stretches:
        message = f"holds {len(times)} rows"
        raise Problem(message=message, file=table.source, expected=f"at least {FEWEST} without a gap").error
    rows, seconds = sum(len(r.times) for r in stretches), sum(r.duration for r in stretches)
    pieces = f" in {len(stretches)} pieces" if len(stretches) > 1 else ""
    notes.append(f"{rows:,} rows{pieces}, {seconds:.6g} s at {stretches[0].rate:.6g} Hz")
    return stretches, notes


def _converted(table: RecordedTable, name: str, unit: str) -> AnyArray:
    values, unit_given = table.column(name), table.units.get(name, "") or unit
    try:
        if not same_dimension(unit_given, unit):
            hint = f"a column without a unit is taken to be in {unit}"
            message = "is in a unit that does not fit"
            raise Problem(message=message, file=table.source, key=name, got=unit_given, expected=unit, hint=hint).error
        factor = float(convert_exactly(f"1 {unit_given}", unit))
    except Refusal as error:
        raise error.problem(name, unit_given).at(table.source, 0).error from None
    return values if factor == 1.0 else np.asarray(values * factor)


def _refuse_times(source: str, name: str, times: AnyArray) -> None:
    problem = partial(Problem, file=source, key=name)
    wrong = np.flatnonzero(~np.isfinite(times))
    if len(wrong):
        raise problem(message=f"has no time in row {wrong[0] + 1}").error
    if len(times) < FEWEST:
        raise problem(message="has too few rows", got=str(len(times)), expected=f"at least {FEWEST}").error
    back = np.flatnonzero(np.diff(times) <= 0.0)
    if len(back):
        row = int(back[0]) + 1
        got = f"{times[row - 1]:.9g} s in row {row}, {times[row]:.9g} s in row {row + 1}"
        hint = "sort the rows, or remove those that repeat a time"
        raise problem(message="its time does not grow", got=got, hint=hint).error
