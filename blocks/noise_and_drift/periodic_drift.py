"""Periodic drift: value = nominal (1 + amplitude sin(2 pi t / cycle_time + phase))."""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import sine_of_turns
from proofmass.blocks.declaration.declare import Block, param


class PeriodicDrift(Block):
    """A parameter that follows a cycle: day and night, an air conditioner, the hum of a supply."""

    amplitude: float = param("1", "Largest relative deviation.", default=100.0e-6)
    cycle_time: float = param(
        "s",
        "Duration of one cycle.",
        default=86400.0,
        above=0.0,
        not_driven="the cycles before would move too: take a NumericallyControlledOscillator, and wire its sine to the "
        "offset of a DriftOffset",
    )
    phase: float = param("rad", "Phase at the start.", default=0.0)
    nominal: float = param("{unit}", "Value without deviation.", default=1.0)
    unit: str = param("", "Unit of the value.", default="1")


class Constants(NamedTuple):
    amplitude: float
    cycle_time: float
    phase_in_turns: float
    nominal: float


@PeriodicDrift.constants
def constants(p: PeriodicDrift, period: float) -> Constants:
    return Constants(p.amplitude, p.cycle_time, p.phase / (2.0 * math.pi), p.nominal)


def deviation_at(c: Constants, time: float) -> float:
    """Relative deviation at a time."""
    return c.amplitude * sine_of_turns(time / c.cycle_time + c.phase_in_turns)


@PeriodicDrift.output("{unit}")
def value(c: Constants, time: float) -> float:
    """Nominal value with the deviation applied."""
    return c.nominal * (1.0 + deviation_at(c, time))


@PeriodicDrift.output("1")
def deviation(c: Constants, time: float) -> float:
    """The relative deviation."""
    return deviation_at(c, time)
