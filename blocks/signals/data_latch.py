"""Data latch: output = data while `enable` is true, else that of the last tick in which it was."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class DataLatch(Block):
    """Transparent latch of one bit. SampleAndHold does the same for a number."""

    initially_on: bool = param("", "The bit that is kept before tick 0.", default=False)

    data = Input("1", "Signal to follow.", dtype=bool)
    enable = Input("1", "Whether to follow it.", dtype=bool)


class State(NamedTuple):
    kept: bool


@DataLatch.start
def start(p: DataLatch) -> State:
    return State(p.initially_on)


@DataLatch.output("1")
def output(p: DataLatch, x: State, data: bool, enable: bool) -> bool:
    """The bit."""
    return data if enable else x.kept


@DataLatch.update
def update(p: DataLatch, x: State, data: bool, enable: bool) -> State:
    return State(data if enable else x.kept)
