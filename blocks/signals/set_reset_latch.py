"""Set-reset latch: on = true from `set` to `reset`; where both are true `set_wins` decides."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class SetResetLatch(Block):
    """Remembers that something happened, until told to forget: an alarm, a step of a sequence."""

    set_wins: bool = param("", "Whether it is on where both inputs are true.", default=False)
    initially_on: bool = param("", "Whether it is on before tick 0.", default=False)

    set = Input("1", "Whether to switch on.", dtype=bool)
    reset = Input("1", "Whether to switch off.", dtype=bool)


class State(NamedTuple):
    was_on: bool


@SetResetLatch.start
def start(p: SetResetLatch) -> State:
    return State(p.initially_on)


@SetResetLatch.output("1")
def on(p: SetResetLatch, x: State, set: bool, reset: bool) -> bool:
    """True while the latch is on, from the tick of the input that sets it."""
    return (set and (p.set_wins or not reset)) or (x.was_on and not reset)


@SetResetLatch.update
def update(p: SetResetLatch, x: State, set: bool, reset: bool) -> State:
    return State((set and (p.set_wins or not reset)) or (x.was_on and not reset))
