"""Sum in fixed point of up to four signals of one format: output = first + second + third + fourth, rounded once."""

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedSum(Block):
    """Adder for two to four fixed-point signals; a FixedGain of -1 before an input, or a FixedDifference, subtracts."""

    input_format: Fixed = param("1", "Format of the inputs.", default=Fixed(16, 12))
    output_format: Fixed = param("1", "Format of the output.", default=Fixed(16, 12))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of the output.", default="saturate")
    unit: str = param("", "Unit of inputs and output.", default="1")

    first = Input("{unit}", "First term.", dtype=FixedValue)
    second = Input("{unit}", "Second term.", dtype=FixedValue)
    third = Input("{unit}", "Third term.", dtype=FixedValue, default=0.0)
    fourth = Input("{unit}", "Fourth term.", dtype=FixedValue, default=0.0)


@FixedSum.formats
def formats(p: FixedSum) -> dict[str, Fixed]:
    inputs = dict.fromkeys(("first", "second", "third", "fourth"), p.input_format)
    return {**inputs, "output": p.output_format}


@FixedSum.output("{unit}")
def output(p: FixedSum, first: FixedValue, second: FixedValue, third: FixedValue, fourth: FixedValue) -> FixedValue:
    """The sum."""
    return (first + second + third + fourth).to(p.output_format, p.rounding, p.overflow)
