"""Compensation register without a divider: value' = value (1 - deviation) when loaded.

CompensationRegister divides by 1 + deviation (digital quartz accelerometer, eq. 22 and 30). What
differs is a part deviation^2 of the value, 4e-8 for 200 ppm, and each load corrects what the one
before has left.
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding, clip, fixed
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedCompensationRegister(Block):
    """Number that makes up for the drift of a gain, in fixed point."""

    initial: float = param("1", "Value before any compensation.", default=1.0, above=0.0)
    limit: float = param("1", "Largest deviation from the initial value, relative.", default=0.01, above=0.0, below=1.0)
    input_format: Fixed = param("1", "Format of the deviation.", default=Fixed(24, 23))
    output_format: Fixed = param("1", "Format of the value.", default=Fixed(32, 30))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of the value.", default="saturate")

    deviation = Input("1", "Relative deviation of the gain.", dtype=FixedValue)
    load = Input("1", "Whether to correct for it.", dtype=bool)


class State(NamedTuple):
    value: FixedValue


class Constants(NamedTuple):
    limit: FixedValue
    lowest: FixedValue
    highest: FixedValue


@FixedCompensationRegister.formats
def formats(p: FixedCompensationRegister) -> dict[str, Fixed]:
    value = dict.fromkeys(("x.value", "c.lowest", "c.highest", "value"), p.output_format)
    return {"deviation": p.input_format, "c.limit": p.input_format, **value}


@FixedCompensationRegister.constants
def constants(p: FixedCompensationRegister, period: float) -> Constants:
    ends = [fixed(p.initial * factor, p.output_format, "half_even") for factor in (1.0 - p.limit, 1.0 + p.limit)]
    return Constants(fixed(p.limit, p.input_format, "half_even"), ends[0], ends[1])


@FixedCompensationRegister.start
def start(p: FixedCompensationRegister) -> State:
    return State(fixed(p.initial, p.output_format, "half_even"))


@FixedCompensationRegister.output("1")
def value(p: FixedCompensationRegister, x: State) -> FixedValue:
    """The compensating number."""
    return x.value


@FixedCompensationRegister.update
def update(c: Constants, p: FixedCompensationRegister, x: State, deviation: FixedValue, load: bool) -> State:
    if not load:
        return x
    corrected = x.value - x.value * clip(deviation, -c.limit, c.limit)
    return State(clip(corrected.to(p.output_format, p.rounding, p.overflow), c.lowest, c.highest))
