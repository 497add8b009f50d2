"""Octave shift: output = input 2^octave, by a shift to the left or to the right (Liu, Li, Shen, eq. 6).

Bits that the output's format has no place for are dropped. The octaves of -64 to 64, the range of
the paper's range reduction, are -93 to 92: of exp(-64) no bit is left, and exp(64), of 93 bits
before the point, saturates.
"""

from collections.abc import Iterator

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, clip
from proofmass.blocks.declaration.declare import Block, Input, param

MOST_BITS = 63  # of input and output together, as the shift is done in one register


class FixedOctaveShift(Block):
    """Multiplication by a power of two that is a signal."""

    input_format: Fixed = param("1", "Format of the input.", default=Fixed(18, 16, signed=False))
    octave_format: Fixed = param("1", "Format of the octave, an integer.", default=Fixed(8))
    output_format: Fixed = param("1", "Format of the output.", default=Fixed(32, 16))
    overflow: Overflow = param("", "Handling of values beyond the range of the output.", default="saturate")
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Value to shift.", dtype=FixedValue)
    octave = Input("1", "Power of two.", dtype=FixedValue)


@FixedOctaveShift.requires
def requires(p: FixedOctaveShift) -> Iterator[tuple[str, str]]:
    if p.octave_format.fraction != 0 or p.octave_format.width > 16:
        yield "octave_format", "no fraction bits, and at most 16 in all"
    if p.input_format.width + p.output_format.width > MOST_BITS:
        yield "output_format", f"at most {MOST_BITS} bits together with the input"


@FixedOctaveShift.formats
def formats(p: FixedOctaveShift) -> dict[str, Fixed]:
    return {"input": p.input_format, "octave": p.octave_format, "output": p.output_format}


@FixedOctaveShift.output("{unit}")
def output(p: FixedOctaveShift, input: FixedValue, octave: FixedValue) -> FixedValue:
    """The input times two to the octave."""
    places = octave.mantissa + (p.output_format.fraction - p.input_format.fraction)
    # Further than a width nothing changes any more: all bits are out of range on the left, or dropped on the right.
    left, right = clip(places, 0, p.output_format.width), clip(-places, 0, p.input_format.width)
    return FixedValue((input.mantissa << left) >> right, p.output_format.fraction).to(
        p.output_format, "floor", p.overflow
    )
