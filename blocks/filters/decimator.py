"""Boxcar decimator: y = (u[0] + ... + u[ratio-1]) / ratio over the last whole window."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class Decimator(Block):
    """Average over windows of `ratio` ticks; the output ticks once per window, in the tick after its last sample."""

    ratio: int = param("1", "Ticks of a window.", default=10, at_least=1, at_most=1_000_000_000)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to average.")


class State(NamedTuple):
    filled: int
    total: float
    mean: float


@Decimator.output("{unit}", every="ratio")
def mean(p: Decimator, x: State) -> float:
    """Mean of the last whole window; zero in the first."""
    return x.mean


@Decimator.update
def update(p: Decimator, x: State, input: float) -> State:
    filled = x.filled + 1
    total = x.total + input
    if filled == p.ratio:
        return State(0, 0.0, total / float(p.ratio))
    return State(filled, total, x.mean)
