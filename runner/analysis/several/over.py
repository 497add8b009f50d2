"""Margins of all loops over a parameter, such as a temperature, or over several that move together, as with age."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.files.toml_reader import GraphSource, graph_from
from proofmass.graphs.model.adjustable import Adjustable
from proofmass.graphs.model.changes import changed_blocks
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.loops import AUTO
from proofmass.graphs.studies.study import Study
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.linearisation import At, OperatingPoints
from proofmass.runner.analysis.linearisation.linearise import loop_nodes
from proofmass.runner.analysis.margins.margins import Margins, margins_of
from proofmass.runner.planning.plan import plan, varied

MOST = 1000  # values


@dataclass(frozen=True, eq=False)
class MarginsOver:
    """Margins of loops at each of some values: a row of loops for each."""

    axis: str  # a parameter, or "age"
    unit: str
    values: tuple[float, ...]
    margins: tuple[Mapping[str, Margins], ...]

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        rows = [
            {"value": value, "loops": [margins.as_data() for margins in loops.values()]}
            for value, loops in zip(self.values, self.margins, strict=True)
        ]
        return {"axis": self.axis, "unit": self.unit, "rows": rows}


def margins_over(
    graph: GraphSource,
    parameter: str,
    values: Sequence[float],
    *,
    unit: str = "1",
    loop: str = "",
    at: At = AUTO,
) -> MarginsOver:
    """Return the margins of the loops with each of some values of a parameter, by its name in the flat graph.

    Raises `ModelError` where a loop cannot be told or linearised.

    `graph` keeps all else. `values` are those of the `parameter`, in `unit`. `loop` and `at` are
    those of `margins`.

    >>> from proofmass import margins_over, read_graph
    >>> graph = read_graph("library:closed_loop_accelerometer")
    >>> over = margins_over(graph, "pid.proportional", [1.0, 2.0])
    >>> [round(row["main"].gain_margin, 1) for row in over.margins]
    [4.2, 1.9]
    """
    return _over(graph_from(graph), parameter, unit, list(values), [{parameter: value} for value in values], loop, at)


def margins_over_age(study: Study, *, loop: str = "", at: At = AUTO) -> MarginsOver:
    """Return the margins at each epoch of a study, of a sensor whose parameters drift as their laws
    say without spread.

    Raises `ModelError` for a study without drift.

    The `study` says ages and laws. `loop` and `at` are those of `margins`.

    >>> from proofmass import margins_over_age, read_study
    >>> over = margins_over_age(read_study("library:scale_factor_drift"))
    >>> len(over.values), over.unit, over.margins[-1]["main"].verdict
    (6, 's', 'stable')
    """
    if not study.drift:
        hint = 'add [drift] with "reference.value" = { ramp = "20 ppm/year", relative = true }, and [epochs]'
        raise study.placed(Problem(message="nothing drifts in the study", key="drift", hint=hint)).error
    rows: list[dict[str, float]] = [{} for _ in study.epochs]
    for name, drift in study.drift.items():
        aged = drift.aged(study.nominal(name), study.epochs, 0, 0, 0, normal=lambda *_: 0.0)
        for row, value in zip(rows, aged, strict=True):
            row[name] = value
    return _over(study.graph, "age", "s", list(study.epochs), rows, loop, at)


def _over(
    graph: Graph,
    axis: str,
    unit: str,
    values: Sequence[float],
    rows: Sequence[Mapping[str, float]],
    loop: str,
    at: At,
) -> MarginsOver:
    if len(values) > MOST:
        raise Problem(message="too many values", key=axis, got=str(len(values)), expected=f"{MOST}").error
    planned = plan(graph.changed(probes=()))
    adjustable = Adjustable(planned.graph)
    nodes = loop_nodes(planned, loop)
    margins_by_age, course = [], Course(planned)
    for row in rows:
        changed = varied(planned, changed_blocks(planned.blocks, adjustable.settings(row)))
        points = OperatingPoints(changed, at, course=Course(changed, like=course))
        margins_by_age.append(
            {name: margins_of(points.loop(node), name, ".".join(node)) for name, node in nodes.items()}
        )
    return MarginsOver(axis, unit, tuple(values), tuple(margins_by_age))


def spread_evenly(low: float, high: float, count: int) -> list[float]:
    """Return values from low to high, both included.

    >>> spread_evenly(1.0, 2.0, 3)
    [1.0, 1.5, 2.0]
    """
    return [low + (high - low) * i / (count - 1) for i in range(count)] if count > 1 else [low]


def or_nan(value: float | None) -> float:
    """Return a margin as a number, NaN where there is none."""
    return math.nan if value is None else value
