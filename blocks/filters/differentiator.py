"""Differentiator: H(z) = gain (1 - a) / T (z - 1) / (z - a), a = exp(-2 pi corner T), as in a PID controller."""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import exponential
from proofmass.blocks.declaration.declare import Block, Input, param


class Differentiator(Block):
    """Rate of change of a signal, filtered by a pole: velocity from position, with less noise."""

    gain: float = param("({output_unit})*s/({input_unit})", "Output per input per second.", default=1.0)
    corner_frequency: float = param("Hz", "Frequency of the pole.", default=1000.0, above=0.0)
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1/s")

    input = Input("{input_unit}", "Signal to differentiate.")


class State(NamedTuple):
    slope: float
    before: float


class Constants(NamedTuple):
    gain: float
    decay: float


@Differentiator.constants
def constants(p: Differentiator, period: float) -> Constants:
    decay = exponential(-2.0 * math.pi * p.corner_frequency * period)
    return Constants(p.gain * (1.0 - decay) / period, decay)


@Differentiator.output("{output_unit}")
def output(c: Constants, x: State, input: float) -> float:
    """The rate of change; the input before tick 0 is zero."""
    return c.decay * x.slope + c.gain * (input - x.before)


@Differentiator.update
def update(c: Constants, x: State, input: float) -> State:
    return State(c.decay * x.slope + c.gain * (input - x.before), input)
