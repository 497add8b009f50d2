"""Sine source: output = offset + amplitude sin(2 pi frequency t + phase) (Sarraf et al. 2012, section 3.1, Fig. 6b)."""

import math
from typing import NamedTuple

from proofmass.blocks.declare import Block, param
from proofmass.blocks.elementary import sine_of_turns


class Sine(Block):
    """A sine wave."""

    amplitude: float = param(1.0, "{unit}", "Peak value about the offset.")
    frequency: float = param(90.0, "Hz", "Frequency.", at_least=0.0)
    phase: float = param(0.0, "rad", "Phase at the start.")
    offset: float = param(0.0, "{unit}", "Mean value.")
    unit: str = param("1", "", "Unit of the output.")


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
