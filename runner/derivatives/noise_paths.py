"""Paths of noise through a graph, wherever it is linearised: which outputs and states may have a slope by it.

They are those of what blocks make of their arguments (`passed_on`). Truth values have no slopes, but for those that a
model of one bit stands for.
"""

from collections.abc import Collection, Iterator
from typing import TypeAlias

from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.graphs.model.digraph import with_following
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.derivatives.dual_functions import LEVELS, reaches
from proofmass.runner.derivatives.passed_on import RESULT, ArgumentNames, passed_on
from proofmass.runner.plan.bindings import Binding, BufferBinding, Out, StateBinding, WireBinding
from proofmass.runner.plan.planned import Plan

_Number: TypeAlias = tuple[str, str, str]  # what it is, its block, and its port, field or buffer
_WIRE, _STATE, _BUFFER, _CONSTANTS = "wire", "state", "buffer", "constants"
_LOOPED = ("update", "derivative", "fold")


def reached_by_noise(plan: Plan, noise: Collection[str]) -> set[Endpoint]:
    """Return the outputs that may have slopes by the noise of some blocks, at one operating point or another."""
    edges = dict[_Number, set[_Number]]()
    for name in plan.blocks:
        for made, of in _edges(plan, name):
            for number in of:
                edges.setdefault(number, set()).add(made)
    begin = (made for name in noise for made, _ in _edges(plan, name))
    moving = with_following(begin, lambda number: edges.get(number, ()))
    return {(name, part) for what, name, part in moving if what == _WIRE}


def _edges(plan: Plan, name: str) -> Iterator[tuple[_Number, set[_Number]]]:
    """Yield what a block makes, and from which numbers that follows."""
    kind, drivers = type(plan.blocks[name]), plan.schedule.drivers
    functions = {**kind.output_functions, **{role: kind.functions[role] for role in _LOOPED if role in kind.functions}}
    whole = name in plan.digital or any(reaches(each.function, LEVELS) for each in functions.values())
    whole |= bool(kind.events or kind.corners)
    driven = {(_WIRE, *drivers[name, p]) for p in kind.parameters if (name, p) in drivers}
    if driven:
        yield (_CONSTANTS, name, ""), driven
    for port, behaviour in functions.items():
        yield from _of_function(plan, name, port, behaviour, whole)


def _of_function(
    plan: Plan, name: str, port: str, behaviour: Behaviour, whole: bool
) -> Iterator[tuple[_Number, set[_Number]]]:
    kind = type(plan.blocks[name])
    state = kind.state_class()
    fields: tuple[str, ...] = state._fields if state else ()  # type: ignore[attr-defined]
    given = dict(zip(behaviour.arguments, plan.bindings(name, port), strict=True))
    lists = tuple(n for n, of in given.items() if isinstance(of, BufferBinding | Out))
    is_output = port in kind.output_functions
    found = None if whole else passed_on(behaviour.function, () if is_output else fields, lists)
    every = {number for of in given.values() for number in _numbers(of, fields)} | {(_CONSTANTS, name, "")}

    def numbers(follows: ArgumentNames) -> set[_Number]:
        own = set[_Number]()
        for each in follows:
            argument, _, field = each.partition(".")
            if argument in given:
                own |= {*_numbers(given[argument], (field,) if field else fields)}
            else:  # the first one
                own.add((_CONSTANTS, name, ""))
        return own

    if not is_output:
        for field in fields:
            yield (_STATE, name, field), every if found is None else numbers(found[field])
    elif whole or kind.outputs[port].dtype is not bool:
        written = [RESULT, *(argument for argument, of in given.items() if isinstance(of, Out))]
        follows = every if found is None else numbers(ArgumentNames().union(*(found[each] for each in written)))
        yield (_WIRE, name, port), follows
    for argument in lists:
        of = given[argument]
        if isinstance(of, BufferBinding):
            yield (_BUFFER, *of.node), every if found is None else numbers(found[argument])


def _numbers(of: Binding, fields: tuple[str, ...]) -> Iterator[_Number]:
    match of:
        case StateBinding(name):
            yield from ((_STATE, name, field) for field in fields)
        case WireBinding((name, port)):
            yield _WIRE, name, port
        case BufferBinding((name, buffer)):
            yield _BUFFER, name, buffer
