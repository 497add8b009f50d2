"""Edge detector: rising = input and not before, falling = before and not input, `before` the input of the last tick."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class EdgeDetector(Block):
    """Marks for one tick that a bit has changed: triggers, zero crossings, ends of a gate."""

    initially_on: bool = param("", "The input before tick 0.", default=False)

    input = Input("1", "Bit to watch.", dtype=bool)


class State(NamedTuple):
    before: bool


@EdgeDetector.start
def start(p: EdgeDetector) -> State:
    return State(p.initially_on)


@EdgeDetector.output("1")
def rising(p: EdgeDetector, x: State, input: bool) -> bool:
    """True in the tick in which the input becomes true."""
    return input and not x.before


@EdgeDetector.output("1")
def falling(p: EdgeDetector, x: State, input: bool) -> bool:
    """True in the tick in which the input becomes false."""
    return x.before and not input


@EdgeDetector.output("1")
def either(p: EdgeDetector, x: State, input: bool) -> bool:
    """True in the tick in which the input changes."""
    return input != x.before


@EdgeDetector.update
def update(p: EdgeDetector, x: State, input: bool) -> State:
    return State(input)
