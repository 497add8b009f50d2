"""Comparator with offset, hysteresis and delay: as a Comparator, but it answers `delay` ticks after its input.

on[n] = decision[n - delay]; a decision is true where input >= threshold + h/2, false where input <
threshold - h/2, else as before; h is the hysteresis. Before the first decision it is off.
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import two_level
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class DelayedComparator(Block):
    """Comparator with a delay: the delay of a sigma-delta loop, of a zero crossing detector."""

    threshold: float = param("{unit}", "Input about which it switches: offset of the comparator.", default=0.0)
    hysteresis: float = param(
        "{unit}", "From where it switches off to where it switches on.", default=0.0, at_least=0.0
    )
    delay: int = param("1", "Ticks until it answers.", default=2, at_least=1, at_most=1_000_000)
    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "What is compared.")

    line = Buffer("Signs of the last decisions.", float, ("delay",))


class State(NamedTuple):
    was_on: bool
    oldest: int  # its place in the line


class Constants(NamedTuple):
    lower: float
    upper: float


@DelayedComparator.constants
def constants(p: DelayedComparator, period: float) -> Constants:
    return Constants(p.threshold - 0.5 * p.hysteresis, p.threshold + 0.5 * p.hysteresis)


@DelayedComparator.start
def start(p: DelayedComparator, line: list[float]) -> State:
    for i in range(p.delay):
        line[i] = -1.0
    return State(False, 0)


@DelayedComparator.output("1")
def on(c: Constants, x: State, line: list[float]) -> bool:
    """True while the answer is on."""
    return line[x.oldest] > 0.0


@DelayedComparator.output("1")
def sign(c: Constants, x: State, line: list[float]) -> float:
    """1 while it is on, -1 while it is off."""
    return line[x.oldest]


@DelayedComparator.update
def update(c: Constants, x: State, line: list[float], input: float) -> State:
    is_on = input >= c.upper or (x.was_on and input >= c.lower)
    line[x.oldest] = two_level(is_on, input)
    return State(is_on, x.oldest + 1 if x.oldest + 1 < len(line) else 0)
