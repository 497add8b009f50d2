"""Difference in fixed point of two signals of one format: output = first - second, rounded once."""

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedDifference(Block):
    """Subtractor for two fixed-point signals."""

    input_format: Fixed = param("1", "Format of both inputs.", default=Fixed(16, 12))
    output_format: Fixed = param("1", "Format of the output.", default=Fixed(16, 12))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of the output.", default="saturate")
    unit: str = param("", "Unit of inputs and output.", default="1")

    first = Input("{unit}", "Signal to subtract from.", dtype=FixedValue)
    second = Input("{unit}", "Signal to subtract.", dtype=FixedValue)


@FixedDifference.formats
def formats(p: FixedDifference) -> dict[str, Fixed]:
    return {"first": p.input_format, "second": p.input_format, "output": p.output_format}


@FixedDifference.output("{unit}")
def output(p: FixedDifference, first: FixedValue, second: FixedValue) -> FixedValue:
    """The difference."""
    return (first - second).to(p.output_format, p.rounding, p.overflow)
