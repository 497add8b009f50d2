"""Sources that a proof at rest takes as constant: each is a `Constant` of the same name."""

from collections.abc import Mapping
from typing import Any

from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.problem import Problem, Refusal, shown
from proofmass.blocks.sources.constant import Constant
from proofmass.graphs.model.graph import Graph
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.design.proof.quantity_claims import number_of
from proofmass.runner.plan.planned import Plan


def with_constants(graph: Graph, planned: Plan, constants: Mapping[str, Any]) -> Graph:
    """Return the graph with constant values at some outputs, such as "0.1 V" at "step.output".

    Raises `ModelError` for an output that is not there or not that of a source, and for a value in another unit.
    """
    blocks, names = dict(graph.blocks), set[str]()
    for signal, value in constants.items():
        name, port = node_of(planned, signal)
        block = planned.blocks[name]
        if name not in graph.blocks or [*type(block).outputs] != ["output"]:
            raise planned.graph.placed(_no_source(signal, name)).error
        unit = unit_of(block, type(block).outputs[port])
        try:
            number = number_of(value, unit)
            if not abs(number) < 1e300:
                raise Refusal("must be a finite number", got=shown(value))
        except Refusal as error:
            got, expected = error.got or shown(value), error.expected or f"a value in {unit}"
            problem = Problem(message=str(error), key=signal, got=got, expected=expected, hint=error.hint)
            raise planned.graph.placed(problem).error from None
        blocks[name] = Constant(value=number, unit=unit or "1")
        names.add(name)
    if not names:
        return graph
    wires = tuple(wire for wire in graph.wires if wire.target.partition(".")[0] not in names)
    formulas = {key: one for key, one in graph.formulas.items() if key.partition(".")[0] not in names}
    return graph.changed(blocks=blocks, wires=wires, formulas=formulas)


def _no_source(signal: str, name: str) -> Problem:
    return Problem(
        message=f"{signal} cannot be given a constant value",
        key=signal,
        expected="the output of a block of the graph itself that has no other output",
        hint="name a source, such as step.output",
        path=("blocks", name),
    )
