"""Meaning of the arguments of a block's functions, which follows from their names alone."""

from collections.abc import Container
from enum import Enum


class Meaning(Enum):
    """Meaning of an argument: one with a fixed name, or a buffer or input of the block; `number` is
    its type if it is one number whatever the block.
    """

    STATE = "x", "the state, an argument of functions"
    PARAMETERS = "p", "the parameters, the first argument of functions"
    TIME = "time", "seconds since the start, tick times period", float
    TICK = "tick", "ticks of the block since the start", int
    DEVIATE = "normal", "a fresh standard normal deviate, a pure function of (seed, run, block, tick)", float
    OUT = "out", "where an output with a shape writes its entries"
    PERIOD = "period", "seconds between ticks, an argument of `constants` and `start`", float
    BUFFER = "", "a buffer of the block, by its name"
    INPUT = "", "an input of the block, by its name"

    def __init__(self, argument: str, doc: str, number: type | None = None) -> None:
        self.argument, self.doc, self.number = argument, doc, number


_FIXED = {meaning.argument: meaning for meaning in Meaning if meaning.argument}


def meaning_of(argument: str, buffers: Container[str]) -> Meaning:
    """Return what an argument means in a block with these buffers.

    >>> meaning_of("time", ["line"]), meaning_of("line", ["line"]), meaning_of("force", ["line"])
    (<Meaning.TIME: ...>, <Meaning.BUFFER: ...>, <Meaning.INPUT: ...>)
    """
    return _FIXED.get(argument) or (Meaning.BUFFER if argument in buffers else Meaning.INPUT)
