"""Golden results: the measures and margins of a graph as they were, in a file beside it, with tolerances.

The file is JSON: a `tolerance` for all, and for each quantity its value, unit, and, where a person
has added them, `absolute` and `relative` of its own.
"""

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.loops import AUTO, MARGIN_MEASURES
from proofmass.runner.output.export import write_whole
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


def quantities(measurements: Measurements) -> Iterator[tuple[str, float, str]]:
    """Yield name, value and unit of each measure, and of each margin of the loops."""
    flat = measurements.flat
    if flat.measures:
        yield from ((name, measured.value, measured.unit) for name, measured in measurements.run.measures.items())
    if flat.loops:
        for name, value in measurements.margins(AUTO).items():
            yield name, value, MARGIN_MEASURES[name.rpartition(".")[2]]


def record(measurements: Measurements, path: Path) -> int:
    """Write the golden results of a graph, and return how many quantities there are; `OSError`."""
    entries = {name: {"value": _written(value), "unit": unit} for name, value, unit in quantities(measurements)}
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
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        hint = "record it again: proofmass verify GRAPH --record"
        message = f"is not a file of golden results: {type(error).__name__} {error}"
        raise Problem(message=message, file=str(path), hint=hint).error from None
    return golden


def compared(measurements: Measurements, golden: Golden) -> list[Finding]:
    """Return a finding for each quantity that was recorded, with its tolerance as limits."""
    now = {name: (value, unit) for name, value, unit in quantities(measurements)}
    findings = []
    for name, entry in golden.entries.items():
        value, unit = now.get(name, (math.nan, ""))
        was = _read(entry["value"])
        allowed = _allowed(golden, entry, abs(was))
        low, high = (was, was) if math.isinf(was) else (was - allowed, was + allowed)
        if unit != entry.get("unit", unit) or (math.isnan(was) and name not in now):
            value = math.nan
        if math.isnan(was) and math.isnan(value) and name in now:  # as before: without a value
            value, low, high = 0.0, 0.0, 0.0
        text = "As it was recorded." if name in now else "Recorded, and not there any more."
        findings.append(Finding(f"golden.{name}", text, name, str(entry.get("unit", unit)), value, low, high))
    return findings


def _allowed(golden: Golden, entry: Mapping[str, Any], size: float) -> float:
    own = {key: float(entry.get(key, golden.tolerance.get(key, 0.0))) for key in ("absolute", "relative")}
    return own["absolute"] + (own["relative"] * size if math.isfinite(size) else 0.0)


def _written(value: float) -> float | str:
    return value if math.isfinite(value) else str(value)


def _read(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise TypeError("a value is a number")
    return float(value)
