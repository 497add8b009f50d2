"""Correlated double sampling: output = u at place `second` of a window - u at place `first`, once in `window` ticks.

What does not move between the two samples falls out: offset, 1/f noise, the noise of a reset (Enz
and Temes, Proc. IEEE 84, 1996, section III).
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class CorrelatedDoubleSampling(Block):
    """Difference of two samples, one of the reset and one of the signal."""

    window: int = param("1", "Ticks of a window.", default=2, at_least=2, at_most=1_000_000)
    first: int = param("1", "Tick of the window at which the reset is sampled.", default=0, at_least=0)
    second: int = param("1", "Tick of the window at which the signal is sampled.", default=1, at_least=1)
    unit: str = param("", "Unit of input and output.", default="V")

    input = Input("{unit}", "Reset and signal in turn.")


class State(NamedTuple):
    place: int
    reset: float
    difference: float
    finished: float


@CorrelatedDoubleSampling.requires
def requires(p: CorrelatedDoubleSampling) -> Iterator[tuple[str, str]]:
    if p.first >= p.second:
        yield "first", f"less than second = {p.second}"
    if p.second >= p.window:
        yield "second", f"less than window = {p.window}"


@CorrelatedDoubleSampling.output("{unit}", every="window")
def difference(p: CorrelatedDoubleSampling, x: State) -> float:
    """Signal less reset of the last whole window; zero in the first."""
    return x.finished


@CorrelatedDoubleSampling.update
def update(p: CorrelatedDoubleSampling, x: State, input: float) -> State:
    reset = input if x.place == p.first else x.reset
    difference = input - reset if x.place == p.second else x.difference
    if x.place + 1 < p.window:
        return State(x.place + 1, reset, difference, x.finished)
    return State(0, reset, difference, difference)
