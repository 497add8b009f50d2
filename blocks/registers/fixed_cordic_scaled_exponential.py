"""CORDIC exponential of a factor: output = preloaded K exp(angle), 0 <= angle < 1 (Liu, Li, Shen, section 3).

The rotations of FixedCordicExponential begin at `preloaded` instead of 1/K, so that factor
exp(angle) needs no multiplier where a memory holds factor / K (the paper counts three multipliers
an exponential). A small factor has few significant bits to begin with: its format decides the
accuracy.
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.cordic import grown, hyperbolic_angles, hyperbolic_shifts
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.arithmetic.mantissa import left_over
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedCordicScaledExponential(Block):
    """Exponential of an angle below 1 times a preloaded factor, within one tick."""

    fraction_bits: int = param("1", "M, of the angle.", default=16, at_least=4, at_most=32)
    iterations: int = param("1", "n, rotations without the repeated ones.", default=16, at_least=1, at_most=40)
    guard_bits: int = param("1", "Further fraction bits of the registers.", default=0, at_least=0, at_most=16)
    preloaded_format: Fixed = param(
        "1", "Format of the preloaded value; the output has two bits more.", default=Fixed(18, 16)
    )
    unit: str = param("", "Unit of factor and output.", default="1")

    angle = Input("1", "Exponent, as a FixedRangeReducer leaves it.", dtype=FixedValue)
    preloaded = Input("{unit}", "Factor divided by the growth K = 0.82816 of the rotations.", dtype=FixedValue)


class Constants(NamedTuple):
    angles: tuple[int, ...]
    output: Fixed


@FixedCordicScaledExponential.formats
def formats(p: FixedCordicScaledExponential) -> dict[str, Fixed]:
    output = Fixed(p.preloaded_format.width + 2, p.preloaded_format.fraction, p.preloaded_format.signed)
    angle = Fixed(p.fraction_bits, p.fraction_bits, signed=False)
    return {"angle": angle, "preloaded": p.preloaded_format, "output": output}


@FixedCordicScaledExponential.constants
def constants(p: FixedCordicScaledExponential, period: float) -> Constants:
    return Constants(hyperbolic_angles(p.iterations, p.fraction_bits + p.guard_bits), formats(p)["output"])


@FixedCordicScaledExponential.output("{unit}")
def output(c: Constants, p: FixedCordicScaledExponential, angle: FixedValue, preloaded: FixedValue) -> FixedValue:
    """The factor times the exponential."""
    value, rest = preloaded.mantissa << p.guard_bits, angle.mantissa << p.guard_bits
    for shift, step in zip(hyperbolic_shifts(p.iterations), c.angles, strict=True):
        value, rest = grown(value, rest, shift, step)
    value += left_over(rest, 1 << (p.fraction_bits + p.guard_bits), value)
    return FixedValue(value, c.output.fraction + p.guard_bits).to(c.output, "floor", "refuse")
