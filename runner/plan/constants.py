"""Constants of a block, which its functions take as first argument, and its initial state."""

import typing
from collections.abc import Callable, Mapping
from typing import Any

from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.language.arithmetic import HIGHEST, LOWEST
from proofmass.blocks.language.forms import constants_form, form_of
from proofmass.runner.fixed.step_formats import held_as


def constants_of(block: Block, parameters: Any, period: float) -> Any:
    """The constants of a block, or its numeric parameters where it declares none."""
    kind = type(block)
    if "constants" in kind.functions:
        form, behaviour = constants_form(kind), kind.functions["constants"]
        function = behaviour.function if form is None or form.problems else form.function
        constants = function(parameters, *behaviour.named({"period": period}))
    else:
        record: Any = kind.parameters_class()
        constants = record(*(getattr(parameters, name) for name in record._fields))
    return typed(constants)


def in_python(block: Block, behaviour: Behaviour) -> Callable[..., Any]:
    """Return a function of a block for plain Python; a user's own function in the form that compiled code has too."""
    form = form_of(type(block), behaviour)
    return behaviour.function if form is None or form.function is None else form.function


def start_of(block: Block, buffers: Mapping[str, list[float]], period: float) -> Any:
    """State at tick 0; may fill the buffers."""
    if "start" in type(block).functions:
        start = type(block).functions["start"]
        return typed(start.function(block, *start.named({**buffers, "period": period})))
    state = type(block).state_class()
    return None if state is None else state(*(held_as(kind)(0) for kind in state.__annotations__.values()))


def typed(values: Any) -> Any:
    """Return a NamedTuple, each field converted to its declared type, as in the compiled loop."""
    if values is None:
        return None
    kinds = type(values).__annotations__.values()
    return type(values)(*(_typed(kind, value) for kind, value in zip(kinds, values, strict=True)))


def _typed(kind: Any, value: Any) -> Any:
    if not isinstance(value, tuple):
        made = held_as(kind)(value)
        if isinstance(made, int) and not LOWEST <= made <= HIGHEST:
            raise OverflowError(f"{made} does not fit 64 bits")
        return made
    kinds = typing.get_args(kind) or (float,)
    kinds = kinds[:1] * len(value) if len(kinds) < 2 or kinds[1] is Ellipsis else kinds
    return tuple(_typed(of, entry) for of, entry in zip(kinds, value, strict=True))
