"""Fixed-point value as a number: output = mantissa 2^-fraction, exactly."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.declaration.declare import Block, Input, param

MOST_BITS = 53  # of an integer that a float holds


class FixedToNumber(Block):
    """Converter from fixed-point values to numbers, without error."""

    input_format: Fixed = param("1", "Format of the input.", default=Fixed(16, 12))
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Value to convert.", dtype=FixedValue)


class Constants(NamedTuple):
    step: float


@FixedToNumber.requires
def requires(p: FixedToNumber) -> Iterator[tuple[str, str]]:
    if p.input_format.width > MOST_BITS:
        yield "input_format", f"at most {MOST_BITS} bits, which is what a number holds exactly"


@FixedToNumber.formats
def formats(p: FixedToNumber) -> dict[str, Fixed]:
    return {"input": p.input_format}


@FixedToNumber.constants
def constants(p: FixedToNumber, period: float) -> Constants:
    return Constants(math.ldexp(1.0, -p.input_format.fraction))


@FixedToNumber.output("{unit}")
def output(c: Constants, input: int) -> float:
    """The value; the input comes as its mantissa."""
    return c.step * input
