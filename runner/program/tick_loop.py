"""A tick loop: its program, and the places of the numbers that a run gives it."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from proofmass.blocks.declaration.instance import shape_of
from proofmass.blocks.language.forms import constants_form
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.fixed.step_formats import held_as
from proofmass.runner.plan.keys import Given, Moving, VectorOf
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.form import Program
from proofmass.runner.program.slots import Slots, fields


@dataclass(frozen=True)
class TickLoop:
    """The program, and the places of its numbers."""

    program: Program
    constants: Slots[Given]
    constant_values: Mapping[Given, Any]
    memory: Slots[Moving]
    vectors: tuple[VectorOf, ...]  # buffers and wires with a shape, in the order of the arguments
    vector_kinds: tuple[type, ...]
    scratch: int  # scratch floats: NaN before the first call of a run, then kept


def settled_before(plan: Plan, varied: Collection[Endpoint]) -> frozenset[str]:
    """Blocks whose varied parameters are fixed before a run starts, because their start or their checks use them."""

    def settled(name: str, parameter: str) -> bool:
        block = plan.blocks[name]
        kinds = [kind for _, kind in fields(type(block).constants_class())]
        form = constants_form(type(block))
        once = not type(block).taken_in_the_loop(parameter) or (form is not None and bool(form.problems))
        return once or any(kind not in (float, int, bool) for kind in kinds)

    return frozenset(name for name, parameter in varied if settled(name, parameter))


def vectors_of(plan: Plan) -> Iterator[tuple[VectorOf, tuple[type, int]]]:
    """Buffers and wires with a shape: the type and number of their entries."""
    for solver in plan.solvers:
        if solver.largest in plan.buffers:
            yield solver.largest, (float, len(solver.group.states))
    for name, block in plan.blocks.items():
        for buffer, declared in type(block).buffers.items():
            yield (name, buffer), (held_as(declared.dtype), len(plan.buffers[name, buffer]))
        for port, output in type(block).outputs.items():
            if output.shape:
                yield (name, port), (held_as(output.dtype), shape_of(block, output)[0])


def bytes_of_a_run(plan: Plan) -> int:
    """About how much memory a tick of a run goes through: constants, states, wires, kept values."""
    states: list[Any] = [type(block).state_class() for block in plan.blocks.values()]
    numbers = sum(len(values) for values in plan.constants.values() if isinstance(values, tuple))
    numbers += sum(len(made._fields) for made in states if made is not None)
    outputs = (output for block in plan.blocks.values() for output in type(block).outputs.values())
    numbers += sum(1 for output in outputs if not output.shape)
    return 8 * (numbers + sum(length for node, (_, length) in vectors_of(plan) if node not in plan.recorded))
