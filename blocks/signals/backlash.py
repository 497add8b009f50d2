"""Backlash: y[n] = y[n-1] held between u[n] - width / 2 and u[n] + width / 2 (Tao and Kokotovic, 1996, chapter 2)."""

from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import clip
from proofmass.blocks.declaration.declare import Block, Input, param


class Backlash(Block):
    """Play between two parts: the driven one stands still until the driver has crossed the gap."""

    width: float = param("{unit}", "Way from one end of the gap to the other.", default=1.0, at_least=0.0)
    initial: float = param("{unit}", "Output before tick 0.", default=0.0)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Position of the driver.")


class State(NamedTuple):
    position: float


@Backlash.start
def start(p: Backlash) -> State:
    return State(p.initial)


@Backlash.output("{unit}")
def output(p: Backlash, x: State, input: float) -> float:
    """Position of the driven part."""
    return clip(x.position, input - 0.5 * p.width, input + 0.5 * p.width)


@Backlash.update
def update(p: Backlash, x: State, input: float) -> State:
    return State(clip(x.position, input - 0.5 * p.width, input + 0.5 * p.width))
