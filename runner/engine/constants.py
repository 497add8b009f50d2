"""What the functions of a block get first, and the state that it starts from."""

from collections.abc import Mapping
from typing import Any

from proofmass.blocks.declare import Block
from proofmass.runner.fixed.step_formats import held_as


def constants_of(block: Block, parameters: Any, period: float) -> Any:
    """The constants of a block, or its numeric parameters where it declares none."""
    if "constants" in block.functions:
        made = block.functions["constants"].function(parameters, period)
    else:
        made = block.parameters_class()(*(getattr(parameters, n) for n in block.parameters_class()._fields))  # type: ignore[attr-defined]
    return typed(made)


def start_of(block: Block, buffers: Mapping[str, list[float]]) -> Any:
    """State at tick 0; may fill the buffers."""
    if "start" in block.functions:
        start = block.functions["start"]
        return typed(start.function(block, *(buffers[name] for name in start.arguments)))
    state = block.state_class()
    return None if state is None else state(*(held_as(kind)(0) for kind in state.__annotations__.values()))


def typed(values: Any) -> Any:
    """A NamedTuple with each field of its declared type, as the compiled loop holds it."""
    if values is None:
        return None
    kinds = map(held_as, values.__annotations__.values())
    return type(values)(*(kind(value) for kind, value in zip(kinds, values, strict=True)))
