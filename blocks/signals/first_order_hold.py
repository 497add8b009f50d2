"""First-order hold: y = u[k] + (u[k] - u[k-1]) i / ratio, i ticks after sample k; delayed y = u[k-1] + the same.

(Franklin, Powell and Workman, Digital Control of Dynamic Systems, 1998, section 5.4.)
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class FirstOrderHold(Block):
    """Straight lines through slow samples at a fast rate; a wire from a slow block to a fast one holds steps."""

    ratio: int = param("1", "Ticks of this block per sample of its input.", default=10, at_least=1, at_most=1_000_000)
    delayed: bool = param(
        "", "Whether it joins the last two samples, one sample late, instead of looking ahead.", default=False
    )
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to sample.")


class State(NamedTuple):
    since: int  # ticks since the last sample
    last: float
    before: float


@FirstOrderHold.output("{unit}")
def output(p: FirstOrderHold, x: State, input: float) -> float:
    """The straight line."""
    last, before = (input, x.last) if x.since == 0 else (x.last, x.before)
    return (before if p.delayed else last) + (last - before) * (float(x.since) / float(p.ratio))


@FirstOrderHold.update
def update(p: FirstOrderHold, x: State, input: float) -> State:
    last, before = (input, x.last) if x.since == 0 else (x.last, x.before)
    return State(x.since + 1 if x.since + 1 < p.ratio else 0, last, before)
