"""Step source: output = offset + amplitude for start_time <= t < start_time + duration, otherwise the offset.

A step or a rectangular pulse (Sarraf et al. 2012, section 3.1, Fig. 6a).
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.edges import LATE, instant
from proofmass.blocks.declaration.declare import Block, param


class Step(Block):
    """A value that jumps once and stays, or comes back after a duration."""

    amplitude: float = param("{unit}", "Height of the step above the offset.", default=1.0)
    start_time: float = param(
        "s", "Time at which the step begins: at the first tick not before it.", default=0.0, at_least=0.0
    )
    duration: float = param("s", "Duration of the step; 0 for ever.", default=0.0, at_least=0.0)
    offset: float = param("{unit}", "Value before and after the step.", default=0.0)
    unit: str = param("", "Unit of the output.", default="1")


class Constants(NamedTuple):
    offset: float
    level: float
    first: float
    last: float


@Step.constants
def constants(p: Step, period: float) -> Constants:
    last = instant(p.start_time + p.duration, period) if p.duration > 0.0 else 1.0e300
    return Constants(p.offset, p.offset + p.amplitude, instant(p.start_time, period), last)


@Step.output("{unit}")
def output(c: Constants, time: float) -> float:
    """The step."""
    return c.level if c.first <= LATE * time < c.last else c.offset


@Step.corner
def edges(c: Constants, time: float) -> int:
    return (1 if c.first <= LATE * time else 0) + (1 if c.last <= LATE * time else 0)
