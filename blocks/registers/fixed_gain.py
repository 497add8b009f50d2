"""Gain in fixed point: output = gain * input, an exact product that is rounded once."""

from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding, fixed
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedGain(Block):
    """Multiplication by a constant in its own format, which rounds it to the nearest step."""

    gain: float = param("({output_unit})/({input_unit})", "Output per input.", default=1.0)
    input_format: Fixed = param("1", "Format of the input.", default=Fixed(16, 12))
    gain_format: Fixed = param("1", "Format of the gain.", default=Fixed(18, 14))
    output_format: Fixed = param("1", "Format of the output.", default=Fixed(16, 12))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of the output.", default="saturate")
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "Signal to amplify.", dtype=FixedValue)


class Constants(NamedTuple):
    gain: FixedValue


@FixedGain.formats
def formats(p: FixedGain) -> dict[str, Fixed]:
    return {"input": p.input_format, "c.gain": p.gain_format, "output": p.output_format}


@FixedGain.constants
def constants(p: FixedGain, period: float) -> Constants:
    return Constants(fixed(p.gain, p.gain_format, "half_even"))


@FixedGain.output("{output_unit}")
def output(c: Constants, p: FixedGain, input: FixedValue) -> FixedValue:
    """The input times the gain."""
    return (c.gain * input).to(p.output_format, p.rounding, p.overflow)
