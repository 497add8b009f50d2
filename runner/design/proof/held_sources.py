"""Sources that a proof at rest takes as constant: each is a `Constant` of the same name."""

from collections.abc import Iterable, Mapping
from typing import Any

from proofmass.blocks.declaration.problem import Problem, Refusal, shown
from proofmass.blocks.sources.constant import Constant
from proofmass.graphs.model.graph import Graph
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.design.proof.quantity_claims import both_ends
from proofmass.runner.design.worst.ranges import Range
from proofmass.runner.plan.planned import Plan


def with_constants(
    graph: Graph, planned: Plan, constants: Mapping[str, Any], varied: Iterable[Range]
) -> tuple[Graph, list[Range]]:
    """Return the graph with constant values at some outputs, such as "0.1 V" or "-1..1 V", and these as ranges.

    Raises `ModelError` for an output that is not there or not that of a source, for a value in another unit, and where
    something of that source is `varied`.
    """
    blocks, ranges = dict(graph.blocks), dict[str, Range]()
    for signal, written in constants.items():
        node = node_of(planned, signal)
        name, unit = node[0], planned.unit(node)
        if name not in graph.blocks or [*type(planned.blocks[name]).outputs] != ["output"]:
            raise planned.graph.placed(_no_source(signal, name)).error
        try:
            low, high = both_ends(written if ".." in str(written) else [written] * 2, unit)
        except Refusal as error:
            problem = error.under("", written, f"a value in {unit}").problem(signal, shown(written))
            raise planned.graph.placed(problem).error from None
        middle = 0.5 * low + 0.5 * high
        blocks[name] = Constant(value=middle, unit=unit or "1")
        ranges[name] = Range(f"{name}.value", f"{name}.value", unit, middle, low, high)
    twice = next((r for r in varied if r.name.partition(".")[0] in ranges), None)
    if twice is not None:
        raise planned.graph.placed(_constant(twice)).error
    wires = tuple(wire for wire in graph.wires if wire.target.partition(".")[0] not in ranges)
    formulas = {key: one for key, one in graph.formulas.items() if key.partition(".")[0] not in ranges}
    return graph.changed(blocks=blocks, wires=wires, formulas=formulas) if ranges else graph, [*ranges.values()]


def _constant(varied: Range) -> Problem:
    name = varied.name.partition(".")[0]
    return Problem(
        message="the tolerance is that of a source that is a constant here",
        key=f"tolerances.{varied.written}",
        hint=f'leave it out, and give the constant a range: --constant "{name}.output=-1..1"',
        path=("tolerances", varied.written),
    )


def _no_source(signal: str, name: str) -> Problem:
    return Problem(
        message=f"{signal} cannot be given a constant value",
        key=signal,
        expected="the output of a block of the graph itself that has no other output",
        hint="name a source, such as step.output",
        path=("blocks", name),
    )
