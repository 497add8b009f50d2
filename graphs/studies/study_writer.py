"""A study as TOML text that reads back to the same study: its graph is in it, and only long lists lie beside it."""

import dataclasses
import math
from typing import Any

from proofmass.graphs.files.toml_writer import inline, quoted, write_graph
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.studies.ageing import LAWS, NEEDED_BY, Drift
from proofmass.graphs.studies.changes import CALIBRATION, Change
from proofmass.graphs.studies.distributions import Spread
from proofmass.graphs.studies.empirical import COLUMN
from proofmass.graphs.studies.epochs import NEVER
from proofmass.graphs.studies.study import Study
from proofmass.graphs.studies.study_tables import Limit


def write_study(study: Study, graph: Graph | None = None) -> str:
    """The text of a graph file with a table `[study]`, whose numbers are in the units of their
    parameters and measures.

    `graph` is the study's, with its recordings named from the folder that the text is meant for;
    `files_beside` belong into the same folder. What the sensors are drawn about is written where it
    is the default too: an own block, or a later version, may have another.
    """
    lines = [f"runs = {study.runs}", f"seed = {study.seed}", f"design = {quoted(study.design)}"]
    lines += [f"margins = {quoted(study.margins)}"] if study.margins else []
    tables: dict[str, dict[str, Any]] = {
        "spread": {study.name_of(name): _spread(spread) for name, spread in study.spread.items()},
        "correlation": _correlation(study),
        "sweep": {study.name_of(name): list(values) for name, values in study.sweep.items()},
        "epochs": {"ages": list(study.epochs)},
        "missions": _missions(study),
        "drift": {study.name_of(name): _drift(drift) for name, drift in study.drift.items()},
        "recalibration": _recalibration(study),
        "changes": {name: _change(change) for name, change in study.changes.items()},
        "limits": {name: _limit(limit) for name, limit in study.limits.items()},
        "stop": dict(study.stop),
    }
    for name, table in tables.items():
        if table:
            lines += ["", f"[study.{name}]", *(f"{quoted(key)} = {inline(entry)}" for key, entry in table.items())]
    whole = write_graph(graph or study.graph, as_written=True, kept=study.varying)
    return f"{whole}\n[study]\n" + "\n".join(lines) + "\n"


def files_beside(study: Study) -> dict[str, bytes]:
    """The files that the text names, by their names, which hold the SHA-256 of their content."""
    return dict(spread.column_file for spread in study.spread.values() if spread.column_file)


def _spread(spread: Spread) -> dict[str, Any]:
    if spread.column_file:
        return {"file": spread.column_file[0], "column": COLUMN}
    if spread.shape == "values":
        return {"values": spread.values} | ({"weights": spread.weights} if spread.weights else {})
    more: dict[str, Any] = {"relative": True} if spread.relative else {}
    more |= {"truncated": spread.truncated} if math.isfinite(spread.truncated) else {}
    return {spread.shape: spread.width} | more


def _correlation(study: Study) -> dict[str, dict[str, float]]:
    table: dict[str, dict[str, float]] = {}
    for first, second, coefficient in study.correlation.pairs:
        table.setdefault(study.name_of(first), {})[study.name_of(second)] = coefficient
    return table


def _recalibration(study: Study) -> dict[str, Any]:
    recalibration = study.recalibration
    if not recalibration.carried:
        return {}
    every = [seconds if math.isfinite(seconds) else NEVER for seconds in recalibration.every]
    return {"every": every, "carried": {study.name_of(name): kept for name, kept in recalibration.carried.items()}}


def _changed(entry: Drift | Limit, default: Drift | Limit) -> dict[str, Any]:
    """The fields that are not as they are by default."""
    fields = {field.name: getattr(entry, field.name) for field in dataclasses.fields(entry)}
    return {name: value for name, value in fields.items() if value != getattr(default, name)}


def _missions(study: Study) -> dict[str, Any]:
    found = {drift.mission: drift.history for drift in study.drift.values() if drift.history is not None}
    return {
        name: {"points": list(zip(mission.times, mission.temperatures, strict=True))} for name, mission in found.items()
    }


def _drift(drift: Drift) -> dict[str, Any]:
    """The laws that are not zero, and those at zero without which the others do not read."""
    table = {name: value for name, value in _changed(drift, Drift()).items() if name != "history"}
    laws = {NEEDED_BY[key] for key in table if key in NEEDED_BY}
    laws |= {"arrhenius"} if drift.mission and not laws & {"arrhenius", "cycles"} else set()
    laws |= set() if laws.union(table).intersection(LAWS) else {"ramp"}
    return dict.fromkeys(sorted(laws), 0.0) | table


def _change(change: Change) -> dict[str, Any]:
    since = CALIBRATION if change.since_calibration else change.since
    return {"measure": change.measure, "since": since} | ({"relative": True} if change.relative else {})


def _limit(limit: Limit) -> dict[str, Any]:
    return {"from" if name == "start" else name: value for name, value in _changed(limit, Limit()).items()}
