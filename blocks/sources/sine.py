"""Sine source: output = offset + amplitude sin(2 pi frequency t + phase) (Sarraf et al. 2012, section 3.1, Fig. 6b)."""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import sine_of_turns
from proofmass.blocks.declaration.declare import Block, param


class Sine(Block):
    """A sine wave."""

    amplitude: float = param("{unit}", "Peak value about the offset.", default=1.0)
    frequency: float = param(
        "Hz",
        "Frequency.",
        default=90.0,
        at_least=0.0,
        not_driven="sin(2 pi f t) does not oscillate at a moving frequency f: take a NumericallyControlledOscillator",
    )
    phase: float = param("rad", "Phase at the start.", default=0.0)
    offset: float = param("{unit}", "Mean value.", default=0.0)
    unit: str = param("", "Unit of the output.", default="1")


class Constants(NamedTuple):
    amplitude: float
    frequency: float
    phase_in_turns: float
    offset: float


@Sine.constants
def constants(p: Sine, period: float) -> Constants:
    return Constants(p.amplitude, p.frequency, p.phase / (2.0 * math.pi), p.offset)


@Sine.output("{unit}")
def output(c: Constants, time: float) -> float:
    """The sine wave."""
    return c.offset + c.amplitude * sine_of_turns(c.frequency * time + c.phase_in_turns)
