"""Lead-lag compensator: H(s) = gain (1 + s / (2 pi fz)) / (1 + s / (2 pi fp)) with s = (2 / T) (z - 1) / (z + 1).

Its phase is largest at sqrt(fz fp): a lead where fz < fp, a lag where fz > fp (Franklin, Powell and
Workman, Digital Control of Dynamic Systems, section 6.1).
"""

import math
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class LeadLag(Block):
    """Compensator of first order: adds phase about the crossover, or gain below it."""

    zero_frequency: float = param("Hz", "Corner of the numerator, fz.", default=100.0, above=0.0)
    pole_frequency: float = param("Hz", "Corner of the denominator, fp.", default=1000.0, above=0.0)
    gain: float = param("({output_unit})/({input_unit})", "Gain at rest.", default=1.0)
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "Signal to compensate.")


class State(NamedTuple):
    kept: float


class Constants(NamedTuple):
    b0: float
    b1: float
    a1: float


@LeadLag.constants
def constants(p: LeadLag, period: float) -> Constants:
    zero, pole = 1.0 / (math.pi * p.zero_frequency * period), 1.0 / (math.pi * p.pole_frequency * period)
    scale = 1.0 / (1.0 + pole)
    return Constants(p.gain * (1.0 + zero) * scale, p.gain * (1.0 - zero) * scale, (1.0 - pole) * scale)


@LeadLag.output("{output_unit}")
def output(c: Constants, x: State, input: float) -> float:
    """The compensated signal."""
    return c.b0 * input + x.kept


@LeadLag.update
def update(c: Constants, x: State, input: float) -> State:
    return State(c.b1 * input - c.a1 * (c.b0 * input + x.kept))
