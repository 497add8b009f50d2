"""Limit cycles as text for people and as plain data: those that a describing function predicts, and that of a run."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from proofmass.graphs.model.graph import Graph
from proofmass.runner.analysis.limit_cycles.limit_cycles import LimitCycle, amplitude_unit, predicted, simulated
from proofmass.runner.analysis.margins.text import hertz_text


class LimitCycles(NamedTuple):
    """The limit cycles at the input of a block."""

    block: str
    unit: str
    predicted: Sequence[LimitCycle]
    simulated: LimitCycle | None


def limit_cycles(graph: Graph, block: str) -> LimitCycles:
    """Predict the limit cycles at a block, and run the graph beside them."""
    cycles = predicted(graph, block)
    seen = simulated(graph, block, None if graph.duration or graph.samples else cycles)
    return LimitCycles(block, amplitude_unit(graph, block), cycles, seen)


def limit_cycles_data(graph: Graph, cycles: LimitCycles) -> dict[str, Any]:
    """Return limit cycles as plain data."""
    data = {
        "block": cycles.block,
        "unit": cycles.unit,
        "predicted": [cycle.as_data() for cycle in cycles.predicted],
        "simulated": cycles.simulated.as_data() if cycles.simulated else None,
    }
    return {"graph": graph.name, "limit_cycles": data}


def limit_cycles_lines(cycles: LimitCycles) -> Iterator[str]:
    """Yield limit cycles for people, a line for each."""
    yield f"limit cycles at the input of {cycles.block}"
    rows: Sequence[LimitCycle | None] = cycles.predicted or [None]
    for cycle in rows:
        yield _line("predicted", cycle, cycles.unit, "none")
    yield _line("simulated", cycles.simulated, cycles.unit, "none that lasts")


def _line(source: str, cycle: LimitCycle | None, unit: str, none: str) -> str:
    shown = f" {unit}" if unit != "1" else ""
    text = f"amplitude {cycle.amplitude:.5g}{shown}, {hertz_text(cycle.frequency)}" if cycle else none
    return f"  {source:<17} {text}"
