"""Formats of a block's functions, as `proofmass.runner.fixed.trace` takes them: of ports, state and buffers."""

import inspect
from collections.abc import Mapping
from typing import get_type_hints

from proofmass.blocks.arithmetic.fixed_point import FixedValue
from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block, BufferPort, Port
from proofmass.blocks.declaration.instance import format_of, shape_of
from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.fixed.step_formats import Cleared, Format, Formats, SteadyValue

NO_RANGES: Mapping[str, Format] = {}


def state_formats(block: Block, ranges: Mapping[str, Format] = NO_RANGES) -> Formats:
    """Formats of the state, or None; `ranges` says what is known of integers, by "x.chip", port or buffer."""
    state = type(block).state_class()
    if state is None:
        return None
    kinds = get_type_hints(state)
    return state(*(_format(block, f"x.{field}", kind, ranges) for field, kind in kinds.items()))


def function_formats(
    block: Block, name: str, behaviour: Behaviour, constants: Formats, ranges: Mapping[str, Format] = NO_RANGES
) -> dict[str, Formats]:
    """Formats of the arguments and the result of a function; raises `ModelError` for anything but integers.

    What `ranges` says is known of arguments; of a result nothing is.
    """
    kind = type(block)
    first = next(iter(inspect.signature(behaviour.function).parameters))
    formats = {first: constants, "return": None}
    for argument, meaning in zip(behaviour.arguments, behaviour.meanings, strict=True):
        if meaning.number is int:
            formats[argument] = int
            continue
        if meaning.number is float:
            hint = "count ticks, or make the signal outside and wire it in through a FixedQuantiser"
            message = f"{argument} is a floating-point number, and the block works in fixed point"
            raise Problem(message=message, key=name, hint=hint).error
        match meaning:
            case Meaning.STATE:
                formats[argument] = state_formats(block, ranges)
            case Meaning.PARAMETERS:
                formats[argument] = SteadyValue(block)
            case Meaning.OUT:
                formats[argument] = Cleared(port_formats(block, kind.outputs[name]))
            case Meaning.BUFFER:
                formats[argument] = port_formats(block, kind.buffers[argument], ranges)
            case Meaning.INPUT:
                formats[argument] = port_formats(block, kind.inputs[argument], ranges)
            case _:
                raise TypeError(f"{meaning.name} has no format")
    if behaviour is kind.output_functions.get(name):
        port = kind.outputs[name]
        formats["return"] = None if port.shape else port_formats(block, port)
    elif name in ("update", "start"):
        formats["return"] = state_formats(block)
    return formats


def port_formats(block: Block, port: Port | BufferPort, ranges: Mapping[str, Format] = NO_RANGES) -> Formats:
    """The format of a port or buffer, or a list with that of each entry."""
    one = _format(block, port.name, port.dtype, ranges)
    return [one] * shape_of(block, port)[0] if port.shape else one


def _format(block: Block, text: str, kind: type, ranges: Mapping[str, Format]) -> Format:
    if kind is FixedValue:
        return format_of(block, text)
    return ranges.get(text, kind)
