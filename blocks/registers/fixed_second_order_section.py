"""Second-order section in fixed point: y[n] = b0 u[n] + b1 u[n-1] + b2 u[n-2] - a1 y[n-1] - a2 y[n-2].

Direct form I: the sum of products is exact and is rounded once, into y, which has a format of its
own; the output is a cast of it (Oppenheim and Schafer, Discrete-Time Signal Processing, section
6.9).
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding, fixed
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedSecondOrderSection(Block):
    """Biquad in fixed point, by coefficients as design programs print them; sections in series."""

    b0: float = param("({output_unit})/({input_unit})", "b0.", default=0.25)
    b1: float = param("({output_unit})/({input_unit})", "b1.", default=0.5)
    b2: float = param("({output_unit})/({input_unit})", "b2.", default=0.25)
    a1: float = param("1", "a1, where a0 is 1.", default=-0.25)
    a2: float = param("1", "a2, where a0 is 1.", default=0.25)
    input_format: Fixed = param("1", "Format of the input.", default=Fixed(16, 12))
    coefficient_format: Fixed = param("1", "Format of the coefficients.", default=Fixed(18, 16))
    state_format: Fixed = param("1", "Format of y.", default=Fixed(24, 20))
    output_format: Fixed = param("1", "Format of the output.", default=Fixed(16, 12))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of y and output.", default="saturate")
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "Signal to filter.", dtype=FixedValue)


class State(NamedTuple):
    u1: FixedValue
    u2: FixedValue
    y1: FixedValue
    y2: FixedValue


class Constants(NamedTuple):
    b0: FixedValue
    b1: FixedValue
    b2: FixedValue
    a1: FixedValue
    a2: FixedValue


@FixedSecondOrderSection.formats
def formats(p: FixedSecondOrderSection) -> dict[str, Fixed]:
    inputs = {"input": p.input_format, "x.u1": p.input_format, "x.u2": p.input_format}
    return inputs | {
        "c": p.coefficient_format,
        "x.y1": p.state_format,
        "x.y2": p.state_format,
        "output": p.output_format,
    }


@FixedSecondOrderSection.constants
def constants(p: FixedSecondOrderSection, period: float) -> Constants:
    return Constants(*(fixed(value, p.coefficient_format, "half_even") for value in (p.b0, p.b1, p.b2, p.a1, p.a2)))


def filtered(c: Constants, p: FixedSecondOrderSection, x: State, input: FixedValue) -> FixedValue:
    """y of this tick."""
    total = c.b0 * input + c.b1 * x.u1 + c.b2 * x.u2 - c.a1 * x.y1 - c.a2 * x.y2
    return total.to(p.state_format, p.rounding, p.overflow)


@FixedSecondOrderSection.output("{output_unit}")
def output(c: Constants, p: FixedSecondOrderSection, x: State, input: FixedValue) -> FixedValue:
    """The filtered signal."""
    return filtered(c, p, x, input).to(p.output_format, p.rounding, p.overflow)


@FixedSecondOrderSection.update
def update(c: Constants, p: FixedSecondOrderSection, x: State, input: FixedValue) -> State:
    return State(input, x.u1, filtered(c, p, x, input), x.y1)
