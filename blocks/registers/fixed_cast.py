"""Fixed-point cast: output = input rounded to another format, then brought into its range."""

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedCast(Block):
    """Converter from one fixed-point format to another."""

    input_format: Fixed = param("1", "Format of the input.", default=Fixed(24, 18))
    output_format: Fixed = param("1", "Format of the output.", default=Fixed(16, 12))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of the output.", default="saturate")
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Value to convert.", dtype=FixedValue)


@FixedCast.formats
def formats(p: FixedCast) -> dict[str, Fixed]:
    return {"input": p.input_format, "output": p.output_format}


@FixedCast.output("{unit}")
def output(p: FixedCast, input: FixedValue) -> FixedValue:
    """The input in the other format."""
    return input.to(p.output_format, p.rounding, p.overflow)
