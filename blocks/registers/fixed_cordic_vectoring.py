"""CORDIC magnitude and phase: real + i imaginary = magnitude exp(i phase), by circular rotations (Walther 1971).

The vector is turned by +-atan 2^-i, i = 0 to n - 1, until its imaginary part is gone: the real part
has grown to K times the magnitude, which a product with 1/K takes off, and the sum of the turns is
the phase. A vector to the left is turned by half a turn first. The phase of (0, 0) is 0, as that of
atan2.

The phase of a vector of v steps is off by at most 1/2 + 2^(phase_bits - n + 1) + 2 n
2^(phase_bits - guard_bits) / v steps: half a step is rounding, then come the last turn and the bits
that the rotations drop. With n and guard bits of phase_bits + 4 or more, as by default, it is at
most one step for every vector; so is the magnitude.
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.cordic import circular_angles, circular_growth, to_the_real_axis
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, fixed, where
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedCordicVectoring(Block):
    """Magnitude and phase of a vector of any quadrant, in a tick: of a demodulator, say."""

    input_format: Fixed = param("1", "Format of both parts; the magnitude has one bit more.", default=Fixed(18, 16))
    phase_bits: int = param("1", "Fraction bits of the phase.", default=16, at_least=4, at_most=32)
    iterations: int = param("1", "n, rotations.", default=20, at_least=1, at_most=40)
    guard_bits: int = param("1", "Further fraction bits of the registers.", default=20, at_least=0, at_most=40)
    unit: str = param("", "Unit of both parts and the magnitude.", default="1")

    real = Input("{unit}", "Real part.", dtype=FixedValue)
    imaginary = Input("{unit}", "Imaginary part.", dtype=FixedValue)


class Constants(NamedTuple):
    reciprocal: FixedValue
    half_turn: int
    angles: tuple[int, ...]
    grown: Fixed  # of the real part, with few guard bits: the others would make the product wide
    magnitude: Fixed
    phase: Fixed


@FixedCordicVectoring.formats
def formats(p: FixedCordicVectoring) -> dict[str, Fixed]:
    magnitude = Fixed(p.input_format.width + 1, p.input_format.fraction, p.input_format.signed)
    ports = {"magnitude": magnitude, "phase": Fixed(p.phase_bits + 3, p.phase_bits)}
    return {"real": p.input_format, "imaginary": p.input_format, **ports}


@FixedCordicVectoring.constants
def constants(p: FixedCordicVectoring, period: float) -> Constants:
    port_formats, inner = formats(p), p.phase_bits + p.guard_bits
    finer = p.input_format.width + 2  # 1/K adds under a quarter of a step to the error
    reciprocal = fixed(1.0 / circular_growth(p.iterations), Fixed(finer + 2, finer), "half_even")
    half_turn = round(math.ldexp(math.pi, inner))
    few = min(p.guard_bits, 4)
    grown = Fixed(p.input_format.width + few + 2, p.input_format.fraction + few, p.input_format.signed)
    angles = circular_angles(p.iterations, inner)
    return Constants(reciprocal, half_turn, angles, grown, port_formats["magnitude"], port_formats["phase"])


@FixedCordicVectoring.output("{unit}")
def magnitude(c: Constants, p: FixedCordicVectoring, real: FixedValue, imaginary: FixedValue) -> FixedValue:
    """Length of the vector, at most one step off."""
    grown = _turned(c, p, real, imaginary)[0]
    return (grown.to(c.grown, "floor") * c.reciprocal).to(c.magnitude)


@FixedCordicVectoring.output("1")
def phase(c: Constants, p: FixedCordicVectoring, real: FixedValue, imaginary: FixedValue) -> FixedValue:
    """Angle of the vector from the real axis, from -pi to pi; 0 for (0, 0)."""
    angle = _turned(c, p, real, imaginary)[1].to(c.phase)
    return FixedValue(where((real == 0) & (imaginary == 0), 0, angle.mantissa), angle.fraction)


def _turned(
    c: Constants, p: FixedCordicVectoring, real: FixedValue, imaginary: FixedValue
) -> tuple[FixedValue, FixedValue]:
    inner = p.phase_bits + p.guard_bits
    parts = real.mantissa << p.guard_bits, imaginary.mantissa << p.guard_bits
    x, angle = to_the_real_axis(*parts, c.angles, c.half_turn, 1 << inner)
    return FixedValue(x, p.input_format.fraction + p.guard_bits), FixedValue(angle, inner)
