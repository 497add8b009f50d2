"""Sample and hold: output = signal while `hold` is false, else its last value before."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class SampleAndHold(Block):
    """Follows a signal, and keeps it on command: a latch, a frozen calibration value."""

    initial: float = param("{unit}", "Output when `hold` is true from tick 0 on.", default=0.0)
    unit: str = param("", "Unit of signal and output.", default="1")

    signal = Input("{unit}", "Signal to follow.")
    hold = Input("1", "Whether to keep the value.", dtype=bool)


class State(NamedTuple):
    kept: float


@SampleAndHold.start
def start(p: SampleAndHold) -> State:
    return State(p.initial)


@SampleAndHold.output("{unit}")
def output(p: SampleAndHold, x: State, signal: float, hold: bool) -> float:
    """The signal, or its kept value."""
    return x.kept if hold else signal


@SampleAndHold.update
def update(p: SampleAndHold, x: State, signal: float, hold: bool) -> State:
    return State(x.kept if hold else signal)
