"""Product in fixed point of two signals: output = first * second, exact and then rounded once."""

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedProduct(Block):
    """Multiplier for two fixed-point signals."""

    first_format: Fixed = param("1", "Format of the first factor.", default=Fixed(16, 12))
    second_format: Fixed = param("1", "Format of the second factor.", default=Fixed(18, 14))
    output_format: Fixed = param("1", "Format of the output.", default=Fixed(16, 12))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of the output.", default="saturate")
    first_unit: str = param("", "Unit of the first factor.", default="1")
    second_unit: str = param("", "Unit of the second factor.", default="1")

    first = Input("{first_unit}", "First factor.", dtype=FixedValue)
    second = Input("{second_unit}", "Second factor.", dtype=FixedValue)


@FixedProduct.formats
def formats(p: FixedProduct) -> dict[str, Fixed]:
    return {"first": p.first_format, "second": p.second_format, "output": p.output_format}


@FixedProduct.output("({first_unit})*({second_unit})")
def output(p: FixedProduct, first: FixedValue, second: FixedValue) -> FixedValue:
    """The product."""
    return (first * second).to(p.output_format, p.rounding, p.overflow)
