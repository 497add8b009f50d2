"""Moving average in fixed point: y[n] = (u[n] + u[n-1] + ... + u[n-N+1]) / N with N = 2^order, zero before tick 0.

A running sum that is exact, so that it never drifts, a line of N words, and a shift by the order.
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class FixedMovingAverage(Block):
    """Mean of the last 2, 4, 8, ... samples in fixed point: without a multiplier."""

    order: int = param("1", "Logarithm to base 2 of the number of samples.", default=3, at_least=1, at_most=8)
    input_format: Fixed = param("1", "Format of the input.", default=Fixed(16, 12))
    output_format: Fixed = param("1", "Format of the output.", default=Fixed(16, 12))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of the output.", default="saturate")
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to average.", dtype=FixedValue)

    line = Buffer("Inputs of the ticks before, newest first.", FixedValue, (lambda p: 1 << p.order,))


class State(NamedTuple):
    total: FixedValue  # of the line


def total_format(p: FixedMovingAverage) -> Fixed:
    """Format of a sum that no inputs overflow."""
    return Fixed(p.input_format.width + p.order, p.input_format.fraction, p.input_format.signed)


@FixedMovingAverage.formats
def formats(p: FixedMovingAverage) -> dict[str, Fixed]:
    return {"input": p.input_format, "line": p.input_format, "x.total": total_format(p), "mean": p.output_format}


@FixedMovingAverage.output("{unit}")
def mean(p: FixedMovingAverage, x: State, line: list[FixedValue], input: FixedValue) -> FixedValue:
    """The mean of this sample and those before."""
    total = x.total + input - line[-1]
    return FixedValue(total.mantissa, p.input_format.fraction + p.order).to(p.output_format, p.rounding, p.overflow)


@FixedMovingAverage.update
def update(p: FixedMovingAverage, x: State, line: list[FixedValue], input: FixedValue) -> State:
    total = (x.total + input - line[-1]).to(total_format(p), "floor", "wrap")
    for k in range(len(line) - 1, 0, -1):
        line[k] = line[k - 1]
    line[0] = input
    return State(total)
