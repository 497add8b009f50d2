"""Constants of a block, which its functions take as first argument, and its initial state."""

import typing
from collections.abc import Callable, Mapping
from typing import Any

from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import Refusal, shown
from proofmass.blocks.language.arithmetic import HIGHEST, LOWEST
from proofmass.blocks.language.forms import constants_form, form_of
from proofmass.runner.fixed.step_formats import held_as

_CURES = {int: "write int(...), round(...) or math.floor(...)", bool: "write a comparison, such as value != 0"}


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
    """State at tick 0, of zeros or the defaults of its fields; may fill the buffers."""
    if "start" in type(block).functions:
        start, declared = type(block).functions["start"], type(block).buffers
        sizes = {name: len(buffers[name]) for name in start.arguments if name in declared}
        begin = typed(start.function(block, *start.named({**buffers, "period": period})))
        for name, size in sizes.items():
            held = buffers[name]
            if len(held) != size:
                raise Refusal(f"{name} must keep its {size} entries, and has {len(held)}")
            held[:] = [_typed(name, declared[name].dtype, entry) for entry in held]
        return begin
    state: Any = type(block).state_class()
    return state and typed(state(*(state._field_defaults.get(name, 0) for name in state._fields)))


def typed(values: Any) -> Any:
    """Return a NamedTuple, each field converted to its declared type, as in the compiled loop.

    Raises `Refusal` where a number would be another one as that type.
    """
    if values is None:
        return None
    kinds = type(values).__annotations__.items()
    return type(values)(*(_typed(name, kind, value) for (name, kind), value in zip(kinds, values, strict=True)))


def _typed(name: str, kind: Any, value: Any) -> Any:
    whole = (typing.get_origin(kind) or kind) is tuple
    try:
        made: Any = tuple(value) if whole else held_as(kind)(value)
    except TypeError:
        raise _refused(name, kind, value) from None
    if isinstance(value, str) or (kind in _CURES and made != value):
        raise _refused(name, kind, value)
    if whole:
        kinds = typing.get_args(kind) or (float,)
        kinds = kinds[:1] * len(made) if len(kinds) < 2 or kinds[1] is Ellipsis else kinds
        return tuple(_typed(name, of, entry) for of, entry in zip(kinds, made, strict=True))
    if isinstance(made, int) and not LOWEST <= made <= HIGHEST:
        raise OverflowError(f"{made} does not fit 64 bits")
    return made


def _refused(name: str, kind: Any, value: object) -> Refusal:
    return Refusal(f"{name} must be of type {kind.__name__}, and is {shown(value)}", _CURES.get(kind, ""))
