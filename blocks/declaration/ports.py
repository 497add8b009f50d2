"""Ports and buffers of a block: how they are declared, and their facts."""

import dataclasses
from collections.abc import Callable
from typing import Any

from proofmass.blocks.arithmetic.fixed_point import FixedValue
from proofmass.blocks.declaration.decorators import declares

NumberType = type[float] | type[int] | type[bool] | type[FixedValue]
DeclaredSize = (
    int | str | Callable[[Any], int]
)  # a number, an integer parameter, a list parameter (its length), a function


@dataclasses.dataclass(frozen=True)
class Port:
    """One input or output of a block; unit and shape may name parameters."""

    name: str
    unit: str
    doc: str
    dtype: NumberType
    shape: tuple[DeclaredSize, ...] = ()
    default: float | bool | None = None  # inputs: the value when nothing is connected
    every: DeclaredSize = 1  # outputs: ticks of the block per tick of the port
    no_value: str = ""  # outputs: what has happened where the value is NaN, and what to do

    @property
    def is_number(self) -> bool:
        """True if it carries one number: no vector, no truth value."""
        return not self.shape and self.dtype is not bool


class Input:
    """Declare an input port; its name is the attribute's. With a `default` it may stay unconnected.

    `unit` is a unit or "{parameter}", `doc` a sentence, `dtype` float, int, bool or `FixedValue`.
    `shape` has lengths, or names of parameters that have them.

    >>> from proofmass import Input
    >>> Input("V", "What is delayed.").named("input").unit
    'V'
    """

    @declares('voltage = Input("V", "What is amplified.")')
    def __init__(
        self,
        unit: str,
        doc: str,
        dtype: NumberType = float,
        shape: tuple[DeclaredSize, ...] = (),
        default: float | bool | None = None,
    ) -> None:
        if default is not None and isinstance(default, bool) != (dtype is bool):
            expected = "True or False" if dtype is bool else "a number"
            raise TypeError(f"the default of an input of type {dtype.__name__} must be {expected}, not {default}")
        self._port = Port("", unit, doc, dtype, shape, default)

    def named(self, name: str) -> Port:
        """Return the port under its name."""
        return dataclasses.replace(self._port, name=name)


@dataclasses.dataclass(frozen=True)
class BufferPort:
    """A vector of state, kept by the runner and updated in place."""

    name: str
    doc: str
    dtype: NumberType
    shape: tuple[DeclaredSize, ...]
    recorded: str = ""  # "time" or "value": filled from a recording, as long as it is


class Buffer:
    """Declare a vector of state: a delay line, cells. `start` may fill it, `update` changes it in place.

    `doc` is a sentence, `dtype` float, int or bool. `shape` has lengths, or names of parameters
    that have them.

    >>> from proofmass import Buffer
    >>> Buffer("The last samples.", float, ("ticks",)).named("line").shape
    ('ticks',)
    """

    @declares('line = Buffer("The last samples.", float, ("ticks",))')
    def __init__(self, doc: str, dtype: NumberType, shape: tuple[DeclaredSize, ...]) -> None:
        self._buffer = BufferPort("", doc, dtype, shape)

    def named(self, name: str) -> BufferPort:
        """Return the buffer under its name."""
        return dataclasses.replace(self._buffer, name=name)


class Recording(Buffer):
    """Declare a buffer that the runner fills from the recording named by the block's `file` and `column`.

    `quantity` is "time" (seconds) or "value" (converted to the unit of the block's output).
    """

    def __init__(self, quantity: str, doc: str) -> None:
        self._buffer = BufferPort("", doc, float, (), quantity)
