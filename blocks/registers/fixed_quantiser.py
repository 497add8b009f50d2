"""Quantiser into fixed point: output = round(input 2^f) 2^-f in a format of w bits, f of them after the binary point.

It is where a signal enters the digital part of a graph. Rounding and overflow are those of
`FixedValue.to`, computed in floating point, exactly: the scale is a power of two, and the fraction
that decides is the rest of a subtraction without error. Beyond 2^62 steps the input is clipped
first.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple, get_args

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding
from proofmass.blocks.arithmetic.rounding import clip, round_down, wrapped
from proofmass.blocks.declaration.declare import Block, Input, param

MOST_BITS = 62
HALF_EVEN, HALF_UP, FLOOR, TOWARD_ZERO = range(4)  # of `Rounding`, as the compiled loop takes them
SATURATE, WRAP, REFUSE = range(3)


class FixedQuantiser(Block):
    """Quantiser from numbers to fixed-point values."""

    output_format: Fixed = param("1", "Format of the output.", default=Fixed(16, 12))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of the output.", default="saturate")
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to quantise.")


class State(NamedTuple):
    overflows: int


class Constants(NamedTuple):
    steps: float
    rounding: int
    overflow: int
    lowest: int
    highest: int
    low_bits: int
    sign: int


@FixedQuantiser.requires
def requires(p: FixedQuantiser) -> Iterator[tuple[str, str]]:
    if p.output_format.width > MOST_BITS:
        yield "output_format", f"at most {MOST_BITS} bits"


@FixedQuantiser.formats
def formats(p: FixedQuantiser) -> dict[str, Fixed]:
    return {"output": p.output_format}


@FixedQuantiser.constants
def constants(p: FixedQuantiser, period: float) -> Constants:
    format = p.output_format
    rounding, overflow = get_args(Rounding).index(p.rounding), get_args(Overflow).index(p.overflow)
    sign = 1 << (format.width - 1) if format.signed else 0
    steps = math.ldexp(1.0, format.fraction)
    return Constants(steps, rounding, overflow, format.lowest, format.highest, (1 << format.width) - 1, sign)


@FixedQuantiser.output("{unit}", dtype=FixedValue)
def output(c: Constants, input: float) -> int:
    """The input in the format, as its mantissa; where it refuses, the runner finds it outside."""
    mantissa = _rounded(c, input)
    if c.overflow == SATURATE:
        mantissa = min(max(mantissa, c.lowest), c.highest)
    elif c.overflow == WRAP:
        mantissa = wrapped(mantissa, c.low_bits, c.sign)
    return mantissa


@FixedQuantiser.update
def update(c: Constants, x: State, input: float) -> State:
    mantissa = _rounded(c, input)
    return State(x.overflows + (1 if mantissa < c.lowest or mantissa > c.highest else 0))


def _rounded(c: Constants, input: float) -> int:
    scaled = clip(c.steps * input, -4611686018427387904.0, 4611686018427387904.0)
    below = round_down(scaled)
    rest = scaled - below
    if c.rounding == HALF_EVEN:
        up = rest > 0.5 or (rest == 0.5 and (below & 1) == 1)
    elif c.rounding == HALF_UP:
        up = rest >= 0.5
    else:
        up = c.rounding == TOWARD_ZERO and rest > 0.0 and below < 0
    return below + 1 if up else below
