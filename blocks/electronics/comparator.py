"""Clocked comparator with hysteresis: on where input >= threshold + h/2, off where input <
threshold - h/2, else as before; h is the hysteresis. It answers in the tick in which it reads.
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import two_level
from proofmass.blocks.declaration.declare import Block, Input, param


class Comparator(Block):
    """One-bit quantiser, zero crossing detector, Schmitt trigger at ticks. A Relay switches between ticks."""

    threshold: float = param("{unit}", "Input about which it switches.", default=0.0)
    hysteresis: float = param(
        "{unit}", "From where it switches off to where it switches on.", default=0.0, at_least=0.0
    )
    initially_on: bool = param("", "Whether it is on before tick 0; it counts within the hysteresis.", default=False)
    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "Signal to compare.")


class State(NamedTuple):
    was_on: bool


class Constants(NamedTuple):
    lower: float
    upper: float


@Comparator.constants
def constants(p: Comparator, period: float) -> Constants:
    return Constants(p.threshold - 0.5 * p.hysteresis, p.threshold + 0.5 * p.hysteresis)


@Comparator.start
def start(p: Comparator) -> State:
    return State(p.initially_on)


def is_on(c: Constants, x: State, input: float) -> bool:
    """Return whether the comparator is on once it has read the input."""
    return input >= c.upper or (x.was_on and input >= c.lower)


@Comparator.output("1")
def on(c: Constants, x: State, input: float) -> bool:
    """True while the comparator is on."""
    return is_on(c, x, input)


@Comparator.output("1")
def sign(c: Constants, x: State, input: float) -> float:
    """1 while it is on, -1 while it is off."""
    return two_level(is_on(c, x, input), input)


@Comparator.update
def update(c: Constants, x: State, input: float) -> State:
    return State(is_on(c, x, input))
