"""Unwrapped phase: y[n] = u[n] + P round((y[n-1] - u[n]) / P), the value nearest to the last one; y[-1] = 0.

P is the period of the phase. It follows changes of less than half a period from sample to sample (Oppenheim and
Schafer, Discrete-Time Signal Processing, on continuous phase).
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import nearest_integer
from proofmass.blocks.declaration.declare import Block, Input, param


class PhaseUnwrapper(Block):
    """Takes the jumps off an angle that starts again after a turn: of a resolver, an interferometer, a pattern."""

    turn: float = param("{unit}", "Period of the phase, P.", default=2.0 * math.pi, above=0.0)
    unit: str = param("", "Unit of the phase.", default="rad")

    input = Input("{unit}", "The phase within a period.")


class State(NamedTuple):
    last: float


def unwrapped(turn: float, last: float, phase: float) -> float:
    return phase + turn * nearest_integer((last - phase) / turn)


@PhaseUnwrapper.output("{unit}")
def output(p: PhaseUnwrapper, x: State, input: float) -> float:
    """The phase without jumps."""
    return unwrapped(p.turn, x.last, input)


@PhaseUnwrapper.update
def update(p: PhaseUnwrapper, x: State, input: float) -> State:
    return State(unwrapped(p.turn, x.last, input))
