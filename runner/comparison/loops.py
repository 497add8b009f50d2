"""Margins of the named loops of a graph, at the start of its run, for comparisons."""

import math

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Graph
from proofmass.runner.planning.plan import plan
from proofmass.runner.studies.runs.margins_per_run import margin_measures, margins_at

START = "0 s"
_Row = dict[str, float | str | None]


def margins_of_loops(graph: Graph) -> tuple[dict[str, _Row], str]:
    """Return values and units by name, as measures of a run have them, and why there are none."""
    try:
        planned = plan(graph.changed(probes=()))
        measures, values = margin_measures(planned, START), margins_at(planned, START)
    except ModelError as error:
        return {}, str(error.problems[0])
    pairs = zip(measures, values, strict=True)
    return {m.name: {"value": None if math.isnan(v) else v, "unit": m.unit} for m, v in pairs}, ""
