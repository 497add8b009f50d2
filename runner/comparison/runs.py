"""Two runs compared: graphs, traces within a tolerance, measures."""

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from proofmass.blocks.declaration.catalog import Own
from proofmass.blocks.declaration.libraries import need
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.differences import GraphDifference, differences
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.loops import AUTO
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.result import pieces
from proofmass.runner.studies.runs.margins_per_run import margin_measures, margins_at

SUMMARY, TRACES = "summary.json", "traces.nc"
_LEAST = 5e-324  # the least number above zero
_DEPENDS = ("seed", "ticks", "base_rate", "proofmass")  # facts of a run that its numbers depend on, beside the graph
_WHICH = ("graph_hash", "date")  # tell a run from others
_ANEW = "run it with --out and without --format csv alone"


@dataclass(frozen=True)
class Allowance:
    """Allowed difference: in the unit, and by the largest of the trace or measure before."""

    absolute: float = 0.0
    relative: float = 0.0

    def of(self, size: float) -> float:
        """Return the allowed difference of numbers of some size."""
        return self.absolute + self.relative * size


@dataclass(frozen=True)
class TraceChange:
    """Difference of a signal's traces, from the time `first` on; `problem` says why they cannot be compared."""

    signal: str
    unit: str
    rows: int = 0
    largest: float = 0.0
    rms: float = 0.0
    size: float = 0.0  # largest absolute value before
    first: float | None = None
    problem: str = ""

    @property
    def same(self) -> bool:
        """Return whether it stays within the tolerance."""
        return self.first is None and not self.problem


@dataclass(frozen=True)
class MeasureChange:
    """A measure before and after."""

    name: str
    unit: str
    before: float | None
    after: float | None
    same: bool


@dataclass(frozen=True)
class RunComparison:
    """Two runs: differences of their graphs and seeds, of their traces and measures."""

    graph: tuple[GraphDifference, ...]
    facts: tuple[GraphDifference, ...]
    traces: tuple[TraceChange, ...]
    measures: tuple[MeasureChange, ...]
    margins: tuple[MeasureChange, ...] = ()  # of the named loops, where the graphs differ
    notes: tuple[str, ...] = ()  # on what could not be compared

    @property
    def same(self) -> bool:
        """Return whether all numbers stay within the tolerance; the graphs may differ."""
        rows = (*self.measures, *self.margins)
        return all(trace.same for trace in self.traces) and all(measure.same for measure in rows)

    def as_data(self) -> dict[str, Any]:
        """Return the comparison as plain data."""
        return {
            "same": self.same,
            "graph": [difference.as_data() for difference in self.graph],
            "facts": [difference.as_data() for difference in self.facts],
            "traces": [asdict(trace) | {"same": trace.same} for trace in self.traces],
            "measures": [asdict(measure) for measure in self.measures],
            "margins": [_written(margin) for margin in self.margins],
            "notes": list(self.notes),
        }


def is_run(folder: Path) -> bool:
    """Return whether a folder holds the files of a run."""
    return (folder / SUMMARY).is_file()


def compare_runs(before: Path, after: Path, tolerance: Allowance, own: Own | None = None) -> RunComparison:
    """Compare the runs in two folders, whose graphs may have `own` blocks.

    Raises `ModelError` where there is none, `OSError`.
    """
    first, second = _summary(before), _summary(after)
    (one, why), (other, why_other) = _graph(first, own), _graph(second, own)
    unread = next((f"graphs and margins are not compared: {reason}" for reason in (why, why_other) if reason), "")
    graph = differences(one, other) if one and other else []
    facts = [
        GraphDifference(key, str(first.get(key, "")), str(second.get(key, "")))
        for key in _DEPENDS
        if first.get(key) != second.get(key)
    ]
    traces = tuple(_traces(before, after, (first, second), tolerance))
    measures = tuple(_measures(first.get("measures", {}), second.get("measures", {}), tolerance))
    margins, notes = _margins(one, other, tolerance) if graph and one and other else ((), (unread,) if unread else ())
    return RunComparison(tuple(graph), tuple(facts), traces, measures, margins, notes)


def _margins(before: Graph, after: Graph, tolerance: Allowance) -> tuple[tuple[MeasureChange, ...], tuple[str, ...]]:
    """Compare the margins of the loops of two graphs; equal graphs have equal ones."""
    if not (before.loops or after.loops):
        return (), ()
    (first, why), (second, why_after) = _margins_of_loops(before), _margins_of_loops(after)
    notes = tuple(f"margins are not compared: {reason}" for reason in (why, why_after) if reason)
    return ((), notes) if notes else (tuple(_measures(first, second, tolerance)), ())


def _written(margin: MeasureChange) -> dict[str, Any]:
    """Plain data of a margin; a text where it is without limit, which JSON has no number for."""
    return {key: str(v) if isinstance(v, float) and math.isinf(v) else v for key, v in asdict(margin).items()}


def _summary(folder: Path) -> dict[str, Any]:
    try:
        data = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    except ValueError as error:
        raise _refused(folder, f"{SUMMARY} cannot be read: {error}") from None
    if not isinstance(data, dict):
        raise _refused(folder, f"{SUMMARY} is not a summary of a run")
    return data


def _graph(summary: Mapping[str, Any], own: Own | None) -> tuple[Graph | None, str]:
    """The graph of a run; None, and why, where it has blocks that are not known here."""
    try:
        return read_graph_text(str(summary.get("graph_toml", "")), SUMMARY, own), ""
    except ModelError as error:
        return None, str(error.problems[0])


def _measures(before: Mapping[str, Any], after: Mapping[str, Any], tolerance: Allowance) -> Iterator[MeasureChange]:
    for name in sorted({*before, *after}):
        rows = before.get(name), after.get(name)
        units = list(dict.fromkeys(row["unit"] for row in rows if row))
        was, now = (row["value"] if row else None for row in rows)
        same = all(rows) and len(units) == 1 and _close(was, now, tolerance)
        yield MeasureChange(name, ", now ".join(units), was, now, same)


def _close(was: float | None, now: float | None, tolerance: Allowance) -> bool:
    """Return whether a measure stays within the tolerance; None has no value."""
    if was is None or now is None or math.isinf(was) or math.isinf(now):
        return was == now
    return abs(now - was) <= tolerance.of(abs(was))


def _traces(
    before: Path, after: Path, summaries: tuple[Mapping[str, Any], ...], tolerance: Allowance
) -> Iterator[TraceChange]:
    there = [(folder / TRACES).is_file() for folder in (before, after)]
    if not all(there):
        if any(there):
            raise _refused(before if there[1] else after, f"has no {TRACES}", _ANEW)
        return
    need("h5netcdf")
    # for start-up time: only traces need it
    import h5netcdf

    with h5netcdf.File(before / TRACES, "r") as first, h5netcdf.File(after / TRACES, "r") as second:
        for folder, data, summary in zip((before, after), (first, second), summaries, strict=True):
            if any(str(summary.get(key)) != data.attrs.get(key) for key in (*_DEPENDS, *_WHICH)):
                raise _refused(folder, f"holds no whole run: {TRACES} is not of the run of {SUMMARY}", _ANEW)
        names = dict.fromkeys(
            name for data in (first, second) for name in data.variables if name not in data.dimensions
        )
        for name in names:
            yield _trace(name, first, second, tolerance)


def _trace(name: str, first: Any, second: Any, tolerance: Allowance) -> TraceChange:
    for place, data in (("before", first), ("after", second)):
        if name not in data.variables:
            return TraceChange(name, "", problem=f"not recorded {place}")
    before, after = first.variables[name], second.variables[name]
    unit, now = (str(variable.attrs.get("units", "")) for variable in (before, after))
    times, later = (_Axis(data.variables[v.dimensions[0]]) for data, v in ((first, before), (second, after)))
    if unit != now:
        return TraceChange(name, unit, problem=f"now in {now}")
    if before.shape != after.shape:
        return TraceChange(name, unit, problem=f"{before.shape[0]:,} rows before, {after.shape[0]:,} after")
    if len(times) and (times[1], times[-1]) != (later[1], later[-1]):
        return TraceChange(name, unit, problem="at other times")
    return _compared(TraceChange(name, unit, rows=before.shape[0]), before, after, times, tolerance)


class _Axis:
    """Times of rows, read one at a time."""

    def __init__(self, variable: Any) -> None:
        self.variable = variable

    def __len__(self) -> int:
        return int(self.variable.shape[0])

    def __getitem__(self, row: int) -> float:
        return float(self.variable[min(row, len(self) - 1) if row >= 0 else len(self) + row])


def _compared(of: TraceChange, before: Any, after: Any, times: Any, tolerance: Allowance) -> TraceChange:
    """Compare rows piece by piece; NaN equals NaN, and 0 and -0 are the least of numbers apart."""
    entries, size = math.prod(before.shape[1:]), 0.0
    for start, end in pieces(of.rows, entries) if tolerance.relative else ():
        size = max(size, float(np.nanmax(np.abs(_numbers(before[start:end])), initial=0.0)))
    allowed, largest, squares, first = tolerance.of(size), 0.0, 0.0, None
    for start, end in pieces(of.rows, entries):
        held = before[start:end], after[start:end]
        old, new = map(_numbers, held)
        with np.errstate(invalid="ignore"):
            apart = _apart(*held) if _whole(*held) else np.abs(new - old)
        bits = (held[0] != held[1]) | (np.signbit(old) != np.signbit(new))
        apart[bits & (apart == 0.0)] = _LEAST
        strange = np.isnan(apart)
        if strange.any():  # both NaN, or both the same infinity
            apart[strange] = np.where(
                (old[strange] == new[strange]) | (np.isnan(old) & np.isnan(new))[strange], 0.0, np.inf
            )
        furthest = float(apart.max(initial=0.0))
        if furthest > 0.0:
            largest, squares = max(largest, furthest), squares + float(np.vdot(apart, apart))
        if first is None and not furthest <= allowed:  # NaN allows nothing
            first = times[start + int(np.argmin((apart <= allowed).reshape(end - start, -1).all(axis=1)))]
    rms = math.sqrt(squares / max(of.rows * entries, 1))
    return TraceChange(of.signal, of.unit, of.rows, largest, rms, size, first)


def _whole(before: AnyArray, after: AnyArray) -> bool:
    return before.dtype.kind == after.dtype.kind == "i"


def _apart(before: AnyArray, after: AnyArray) -> AnyArray:
    """Return how far integers are apart, also beyond 2^53: below 2^64, and rounded once."""
    first, second = before.astype(np.int64), after.astype(np.int64)
    return np.asarray((np.maximum(first, second) - np.minimum(first, second)).view(np.uint64), dtype=np.float64)


def _numbers(rows: Any) -> AnyArray:
    return np.asarray(rows, dtype=np.float64)


def _refused(folder: Path, message: str, hint: str = "") -> ModelError:
    return Problem(message=message, file=str(folder), hint=hint).error


def _margins_of_loops(graph: Graph) -> tuple[dict[str, dict[str, float | str | None]], str]:
    """Return the margins as measures have them, and why there are none."""
    try:
        planned = plan(graph.changed(probes=()))
        measures, values = margin_measures(planned, AUTO), margins_at(planned, AUTO)
    except ModelError as error:
        return {}, str(error.problems[0])
    pairs = zip(measures, values, strict=True)
    return {m.name: {"value": None if math.isnan(v) else v, "unit": m.unit} for m, v in pairs}, ""
