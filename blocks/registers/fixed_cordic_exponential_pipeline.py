"""CORDIC exponential, pipelined: exponential[n] = exp(angle[n - L]), L rotations with one register each.

The rotations are those of FixedCordicExponential, and so are the bits; a new angle enters in every
tick, and its exponential comes L ticks later, L the iterations with the repeated ones. Before that
the output is zero.
"""

from proofmass.blocks.arithmetic.cordic import grown, hyperbolic_shifts
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, wrap
from proofmass.blocks.arithmetic.mantissa import left_over
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param
from proofmass.blocks.registers.fixed_cordic_exponential import Constants, exponential_constants, exponential_formats


def latency(p: "FixedCordicExponentialPipeline") -> int:
    """Rotations, and ticks from angle to exponential."""
    return len(hyperbolic_shifts(p.iterations))


class FixedCordicExponentialPipeline(Block):
    """Exponential of an angle below 1, one rotation a tick."""

    fraction_bits: int = param("1", "M, of angle and exponential.", default=16, at_least=4, at_most=32)
    iterations: int = param("1", "n, rotations without the repeated ones.", default=16, at_least=1, at_most=40)
    guard_bits: int = param("1", "Further fraction bits of the registers.", default=0, at_least=0, at_most=16)

    angle = Input("1", "Exponent, as a FixedRangeReducer leaves it.", dtype=FixedValue)

    values = Buffer("X behind each rotation, zero in tick 0.", FixedValue, (latency,))
    rests = Buffer("Z behind each rotation, zero in tick 0.", FixedValue, (latency,))


@FixedCordicExponentialPipeline.formats
def formats(p: FixedCordicExponentialPipeline) -> dict[str, Fixed]:
    inner = p.fraction_bits + p.guard_bits
    registers = {"values": Fixed(inner + 2, inner, signed=False), "rests": Fixed(inner + 2, inner)}
    return {**exponential_formats(p.fraction_bits), **registers}


@FixedCordicExponentialPipeline.constants
def constants(p: FixedCordicExponentialPipeline, period: float) -> Constants:
    return exponential_constants(p.fraction_bits, p.iterations, p.guard_bits)


@FixedCordicExponentialPipeline.output("1")
def exponential(
    c: Constants, p: FixedCordicExponentialPipeline, values: list[FixedValue], rests: list[FixedValue]
) -> FixedValue:
    """The exponential of the angle that entered L ticks ago, in M fraction bits."""
    value, inner = values[-1].mantissa, p.fraction_bits + p.guard_bits
    return FixedValue(value + left_over(rests[-1].mantissa, 1 << inner, value), inner).to(c.output, "floor", "refuse")


@FixedCordicExponentialPipeline.update
def update(
    c: Constants,
    p: FixedCordicExponentialPipeline,
    values: list[FixedValue],
    rests: list[FixedValue],
    angle: FixedValue,
) -> None:
    word, inner = formats(p)["values"], p.fraction_bits + p.guard_bits
    before = [c.start, *(each.mantissa for each in values[:-1])]
    left = [angle.mantissa << p.guard_bits, *(each.mantissa for each in rests[:-1])]
    moved = map(grown, before, left, hyperbolic_shifts(p.iterations), c.angles)
    for i, (value, rest) in enumerate(moved):
        # No angle below 1 brings X to 4: the bit above the register, which intervals alone allow, is never set.
        values[i], rests[i] = FixedValue(wrap(value, word), inner), FixedValue(rest, inner)
