"""Golden results: the measures and margins of a graph as they were, in a file beside it, with tolerances.

The file is JSON: a `tolerance` for all, and for each quantity its value, unit, and, where a person
has added them, `absolute` and `relative` of its own.
"""

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.loops import AUTO, MARGIN_MEASURES
from proofmass.runner.design.quantities.evaluator import refused
from proofmass.runner.output.export import write_whole
from proofmass.runner.run.faults import RunError
from proofmass.runner.run.provenance import graph_hash
from proofmass.runner.verification.verify import Finding, Measurements

RELATIVE = 1e-9
SUFFIX = ".golden.json"


@dataclass(frozen=True)
class Golden:
    """Recorded quantities of a graph."""

    graph_hash: str
    entries: Mapping[str, Mapping[str, Any]]
    tolerance: Mapping[str, float]


def golden_file(graph: Path) -> Path:
    """Return where the golden results of a graph file lie."""
    return graph.with_suffix(SUFFIX)


def measured(measurements: Measurements) -> Iterator[tuple[str, float, str]]:
    """Yield name, value and unit of each measure; raises `RunError`."""
    if measurements.flat.measures:
        yield from ((name, one.value, one.unit) for name, one in measurements.run.measures.items())


def margins(measurements: Measurements) -> Iterator[tuple[str, float, str]]:
    """Yield name, value and unit of each margin of the loops; raises `ModelError`, `RunError`."""
    if measurements.flat.loops:
        for name, value in measurements.margins(AUTO).items():
            yield name, value, MARGIN_MEASURES[name.rpartition(".")[2]]


def record(measurements: Measurements, path: Path) -> int:
    """Write the golden results of a graph, and return how many quantities there are; `OSError`."""
    every = chain(measured(measurements), margins(measurements))
    entries = {name: {"value": _written(value), "unit": unit} for name, value, unit in every}
    if not entries:
        hint = "add [measures] or [loops] to the graph"
        raise Problem(message="there is nothing to record", file=str(path), hint=hint).error
    data = {"graph_hash": graph_hash(measurements.graph), "tolerance": {"relative": RELATIVE}, "quantities": entries}
    write_whole(path, json.dumps(data, indent=2) + "\n")
    return len(entries)


def read_golden(path: Path) -> Golden:
    """Read golden results; raises `ModelError` for any other file, `OSError`."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        entries = {str(name): dict(entry) for name, entry in data["quantities"].items()}
        golden = Golden(str(data.get("graph_hash", "")), entries, dict(data.get("tolerance", {})))
        for entry in entries.values():
            _read(entry["value"])
            _allowed(golden, entry, 0.0)
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError) as error:
        hint = "record it again: proofmass verify GRAPH --record"
        message = f"is not a file of golden results: {type(error).__name__} {error}"
        raise Problem(message=message, file=str(path), hint=hint).error from None
    return golden


def compared(measurements: Measurements, golden: Golden) -> list[Finding]:
    """Return a finding for each quantity that was recorded, with its tolerance as limits."""
    now, why = dict[str, tuple[float, str]](), ""
    for part in (measured, margins):
        try:
            now |= {name: (value, unit) for name, value, unit in part(measurements)}
        except (ModelError, RunError) as error:
            why = refused(error).reason
    return [_compared(golden, name, now.get(name), why) for name in golden.entries]


def _compared(golden: Golden, name: str, now: tuple[float, str] | None, why: str) -> Finding:
    """Return a finding of one quantity: its value and unit now, or why it may have none."""
    entry = golden.entries[name]
    was, unit_then = _read(entry["value"]), str(entry.get("unit", now[1] if now else ""))
    value, unit = now or (math.nan, unit_then)
    allowed, text, reason = _allowed(golden, entry, abs(was)), "As it was recorded.", ""
    low, high = (was, was) if math.isinf(was) else (was - allowed, was + allowed)
    if now is None:
        text, reason = ("As it was recorded.", why) if why else ("Recorded, and not there any more.", "")
    elif unit != unit_then:
        value, reason = math.nan, f"its unit was {unit_then}, and is {unit}"
    elif math.isnan(was) and math.isnan(value):  # as before: without a value
        value, low, high = 0.0, 0.0, 0.0
    return Finding(f"golden.{name}", text, name, unit_then, value, low, high, reason)


def _allowed(golden: Golden, entry: Mapping[str, Any], size: float) -> float:
    own = {key: _read(entry.get(key, golden.tolerance.get(key, 0.0))) for key in ("absolute", "relative")}
    wrong = [value for value in own.values() if not value >= 0.0]
    if wrong:
        raise ValueError(f"a tolerance is at least 0, not {wrong[0]}")
    return own["absolute"] + (own["relative"] * size if math.isfinite(size) else 0.0)


def _written(value: float) -> float | str:
    return value if math.isfinite(value) else str(value)


def _read(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise TypeError("a value is a number")
    return float(value)
