"""Ports and buffers of a block: how they are declared, and what is known of one."""

import dataclasses
from collections.abc import Callable, Iterable
from typing import Any

from proofmass.blocks.arithmetic.fixed_point import FixedValue
from proofmass.blocks.declaration.arguments import Meaning

Number = type[float] | type[int] | type[bool] | type[FixedValue]
Size = int | str | Callable[[Any], int]  # a number, an integer parameter, a list parameter (its length), a function

RESERVED = {meaning.argument: meaning.doc for meaning in Meaning if meaning.argument} | {
    "c": "the constants, the first argument of functions",
    "kind": "a key of a block in a graph file",
    "rate": "a key of a block in a graph file",
    "graph": "a key of a block in a graph file",
}


@dataclasses.dataclass(frozen=True)
class Port:
    """One input or output of a block; unit and shape may name parameters."""

    name: str
    unit: str
    doc: str
    dtype: Number
    shape: tuple[Size, ...] = ()
    default: float | None = None  # inputs: the value when nothing is connected
    every: Size = 1  # outputs: ticks of the block per tick of the port
    no_value: str = ""  # outputs: what has happened where the value is NaN, and what to do


class Input:
    """Declare an input port; its name is the attribute's. With a `default` it may stay unconnected."""

    def __init__(
        self, unit: str, doc: str, dtype: Number = float, shape: tuple[Size, ...] = (), default: float | None = None
    ) -> None:
        self._port = Port("", unit, doc, dtype, shape, default)

    def __set_name__(self, owner: Any, name: str) -> None:
        refuse_taken(owner, name, owner.__mro__[-2].__dict__)  # of Block
        owner.inputs = {**owner.inputs, name: dataclasses.replace(self._port, name=name)}


@dataclasses.dataclass(frozen=True)
class BufferPort:
    """A vector of state, kept by the runner and updated in place."""

    name: str
    doc: str
    dtype: Number
    shape: tuple[Size, ...]
    recorded: str = ""  # "time" or "value": filled from a recording, as long as it is


class Buffer:
    """Declare a vector of state: a delay line, cells. `start` may fill it, `update` changes it in place."""

    def __init__(self, doc: str, dtype: Number, shape: tuple[Size, ...]) -> None:
        self._buffer = BufferPort("", doc, dtype, shape)

    def __set_name__(self, owner: Any, name: str) -> None:
        refuse_taken(owner, name, owner.__mro__[-2].__dict__)  # of Block
        owner.buffers = {**owner.buffers, name: dataclasses.replace(self._buffer, name=name)}


class Recording(Buffer):
    """Declare a buffer that the runner fills from the recording named by the block's `file` and `column`.

    `quantity` is "time" (seconds) or "value" (converted to the unit of the block's output).
    """

    def __init__(self, quantity: str, doc: str) -> None:
        self._buffer = BufferPort("", doc, float, (), quantity)


def refuse_taken(owner: type, name: str, taken: Iterable[str], by: str = "") -> None:
    """Raise TypeError where a name stands for something else in a block."""
    if name in RESERVED:
        raise TypeError(f"{owner.__name__}.{name}: the name is taken; {name} is {RESERVED[name]}")
    if name in taken:
        what = "a method" if callable(getattr(owner.__mro__[-2], name, None)) else "an attribute"
        of = by or f"every block has {what} {name}"
        raise TypeError(f"{owner.__name__}.{name}: the name is taken; {of}")
