"""Finite impulse response in fixed point: y[n] = h0 u[n] + h1 u[n-1] + ... + hm u[n-m].

The taps are rounded to a format; the sum of products is exact and is rounded once (Oppenheim and Schafer,
Discrete-Time Signal Processing, section 6.5).
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding, fixed
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param

MOST_TAPS = 64


class FixedFiniteImpulseResponse(Block):
    """Filter by its taps in fixed point, 1 to 64 of them, each with a multiplier of its own."""

    taps: tuple[float, ...] = param("({output_unit})/({input_unit})", "h0 to hm.", default=(0.25, 0.5, 0.25))
    input_format: Fixed = param("1", "Format of the input.", default=Fixed(16, 12))
    tap_format: Fixed = param("1", "Format of the taps.", default=Fixed(16, 15))
    output_format: Fixed = param("1", "Format of the output.", default=Fixed(16, 12))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of the output.", default="saturate")
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "Signal to filter.", dtype=FixedValue)

    line = Buffer("Inputs of the ticks before, newest first.", FixedValue, (lambda p: max(len(p.taps) - 1, 1),))


class Constants(NamedTuple):
    taps: tuple[FixedValue, ...]


@FixedFiniteImpulseResponse.requires
def requires(p: FixedFiniteImpulseResponse) -> Iterator[tuple[str, str]]:
    if len(p.taps) > MOST_TAPS:
        yield "taps", f"at most {MOST_TAPS} numbers"


@FixedFiniteImpulseResponse.formats
def formats(p: FixedFiniteImpulseResponse) -> dict[str, Fixed]:
    return {"input": p.input_format, "c": p.tap_format, "line": p.input_format, "output": p.output_format}


@FixedFiniteImpulseResponse.constants
def constants(p: FixedFiniteImpulseResponse, period: float) -> Constants:
    return Constants(tuple(fixed(tap, p.tap_format, "half_even") for tap in p.taps))


@FixedFiniteImpulseResponse.output("{output_unit}")
def output(c: Constants, p: FixedFiniteImpulseResponse, line: list[FixedValue], input: FixedValue) -> FixedValue:
    """The filtered signal."""
    total = c.taps[0] * input
    for k in range(1, len(c.taps)):
        total = total + c.taps[k] * line[k - 1]
    return total.to(p.output_format, p.rounding, p.overflow)


@FixedFiniteImpulseResponse.update
def update(c: Constants, p: FixedFiniteImpulseResponse, line: list[FixedValue], input: FixedValue) -> None:
    for k in range(len(line) - 1, 0, -1):
        line[k] = line[k - 1]
    line[0] = input
