"""Step source: output = offset + amplitude for start_time <= t < start_time + duration, otherwise the offset.

A step or a rectangular pulse (Sarraf et al. 2012, section 3.1, Fig. 6a).
"""

from typing import NamedTuple

from proofmass.blocks.declare import Block, param


class Step(Block):
    """A value that jumps once and stays, or comes back after a duration."""

    amplitude: float = param(1.0, "{unit}", "Height of the step above the offset.")
    start_time: float = param(0.0, "s", "When the step begins: at the first tick not before it.", at_least=0.0)
    duration: float = param(0.0, "s", "How long the step lasts; 0 for ever.", at_least=0.0)
    offset: float = param(0.0, "{unit}", "Value before and after the step.")
    unit: str = param("1", "", "Unit of the output.")


class Constants(NamedTuple):
    offset: float
    level: float
    first: float
    last: float


@Step.constants
def constants(p: Step, period: float) -> Constants:
    early = p.start_time - 1.0e-6 * period  # a tick that rounding puts just before an edge is on it
    return Constants(p.offset, p.offset + p.amplitude, early, early + p.duration if p.duration > 0.0 else 1.0e300)


@Step.output("{unit}")
def output(c: Constants, time: float) -> float:
    """The step."""
    return c.level if c.first <= time < c.last else c.offset
