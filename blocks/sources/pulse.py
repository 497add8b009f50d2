"""Pulse source: output = offset + amplitude while frac((t - delay) / repetition) < duty and t >= delay."""

from typing import NamedTuple

from proofmass.blocks.arithmetic.edges import LATE, instant
from proofmass.blocks.arithmetic.rounding import nearest_integer
from proofmass.blocks.declaration.declare import Block, param


class Pulse(Block):
    """A rectangular wave: high for a part of each repetition, low for the rest."""

    amplitude: float = param("{unit}", "Height of the pulses above the offset.", default=1.0)
    offset: float = param("{unit}", "Value between pulses, and before the first.", default=0.0)
    repetition: float = param(
        "s",
        "Time from one pulse to the next.",
        default=1.0,
        above=0.0,
        not_driven="the pulses before would move too: take a NumericallyControlledOscillator of the frequency of the "
        "pulses, and a Comparator behind its sine",
    )
    duty: float = param("1", "Part of a repetition that is high.", default=0.5, at_least=0.0, at_most=1.0)
    delay: float = param("s", "Time at which the first pulse begins.", default=0.0, at_least=0.0)
    unit: str = param("", "Unit of the output.", default="1")


class Constants(NamedTuple):
    offset: float
    level: float
    first: float
    repetition: float
    duty: float


@Pulse.constants
def constants(p: Pulse, period: float) -> Constants:
    return Constants(p.offset, p.offset + p.amplitude, instant(p.delay, period), p.repetition, p.duty)


def part_of(c: Constants, time: float) -> float:
    """Part of a repetition that has passed, from 0 to 1; negative before the first pulse."""
    repetitions = (LATE * time - c.first) / c.repetition
    part = repetitions - nearest_integer(repetitions)
    return repetitions if repetitions < 0.0 else part if part >= 0.0 else part + 1.0


@Pulse.output("{unit}")
def output(c: Constants, time: float) -> float:
    """The rectangular wave."""
    return c.level if 0.0 <= part_of(c, time) < c.duty else c.offset


@Pulse.corner
def edges(c: Constants, time: float) -> int:
    part = part_of(c, time)
    repetitions = nearest_integer((LATE * time - c.first) / c.repetition - part)
    return 2 * int(min(repetitions, 1e15)) + (1 if part < c.duty else 2) if part >= 0.0 else 0
