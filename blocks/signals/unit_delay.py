"""Unit delay: y[n] = u[n-1], z^-1, with a given value in tick 0."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class UnitDelay(Block):
    """Delay of one tick: a register, computing time; it breaks a loop without delay."""

    initial: float = param("{unit}", "Output in tick 0.", default=0.0)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to delay.")


class State(NamedTuple):
    held: float


@UnitDelay.start
def start(p: UnitDelay) -> State:
    return State(p.initial)


@UnitDelay.output("{unit}")
def output(p: UnitDelay, x: State) -> float:
    """The input of the tick before."""
    return x.held


@UnitDelay.update
def update(p: UnitDelay, x: State, input: float) -> State:
    return State(input)
