"""Unwrapped phase: y[n] = u[n] + 2 pi round((y[n-1] - u[n]) / (2 pi)), the value nearest to the last one; y[-1] = 0.

It follows a phase that moves by less than half a turn from sample to sample (Oppenheim and Schafer,
Discrete-Time Signal Processing, on continuous phase).
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import nearest_integer
from proofmass.blocks.declaration.declare import Block, Input

TURN = 2.0 * math.pi


class PhaseUnwrapper(Block):
    """Takes the jumps off an angle that starts again after a turn: of a resolver, an interferometer, a pattern."""

    input = Input("rad", "The phase, up to whole turns.")


class State(NamedTuple):
    last: float


def nearest(last: float, phase: float) -> float:
    """The phase with so many turns that it is nearest to the last one."""
    return phase + TURN * nearest_integer((last - phase) / TURN)


@PhaseUnwrapper.output("rad")
def output(p: PhaseUnwrapper, x: State, input: float) -> float:
    """The phase without jumps."""
    return nearest(x.last, input)


@PhaseUnwrapper.update
def update(p: PhaseUnwrapper, x: State, input: float) -> State:
    return State(nearest(x.last, input))
