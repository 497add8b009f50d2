"""Wires of which a port is not named: what was meant, where blocks and units leave one choice."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Port
from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.unit_expressions import UnitError
from proofmass.blocks.declaration.units import same_unit

_SHOWN = 3  # wires in a hint


class _End(NamedTuple):
    """An end that may have been meant."""

    signal: str
    block: Block
    port: Port


def whole_wire(text: object, blocks: Mapping[str, object]) -> str:
    """Return a hint for a wire such as "inertia -> sensor"; empty where the blocks are not known.

    >>> from proofmass.blocks import Gain, Step
    >>> whole_wire("step -> gain", {"step": Step(), "gain": Gain()})
    'write "step.output -> gain.input"'
    """
    ends = [end.strip() for end in text.split("->")] if isinstance(text, str) else []
    if len(ends) != 2:
        return ""
    sources, targets = (list(_ends(end, blocks, number)) for number, end in enumerate(ends))
    wires = [(source, target) for source in sources for target in targets]
    meant = [wire for wire in wires if _fit(*wire)] or wires
    written = [f'"{source.signal} -> {target.signal}"' for source, target in meant]
    return f"write {' or '.join(written[:_SHOWN])}" if written else ""


def _ends(text: str, blocks: Mapping[str, object], number: int) -> Iterator[_End]:
    """Yield the ports that an end may mean: the named one, or all outputs or inputs of the block."""
    name, dot, port = text.partition(".")
    block = blocks.get(name)
    if isinstance(block, Block):
        ports = type(block).inputs if number else type(block).outputs
        named = {port: ports[port]} if port in ports else {} if dot else ports
        yield from (_End(f"{name}.{key}", block, one) for key, one in named.items())


def _fit(source: _End, target: _End) -> bool:
    """Return whether type and unit are the same."""
    try:
        same = same_unit(unit_of(source.block, source.port), unit_of(target.block, target.port))
    except UnitError:
        return False
    return same and source.port.dtype is target.port.dtype and bool(source.port.shape) == bool(target.port.shape)
