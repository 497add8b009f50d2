"""Integrators and combs in registers that wrap: ((1 - z^-R) / (R (1 - z^-1)))^order, R = 2^bits, once in R ticks.

Integrators run at every tick, combs once in R; all have the width of the input and order times bits
more, so that what the integrators wrap the combs take off (Hogenauer, IEEE Trans. ASSP 29, 1981).
The division by R^order is a shift.
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding, where
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class FixedCascadedIntegratorComb(Block):
    """Decimation filter without a multiplier; the same numbers as a CascadedIntegratorComb before its rounding."""

    order: int = param("1", "Integrators, and combs.", default=3, at_least=1, at_most=6)
    bits: int = param("1", "Logarithm to base 2 of the ticks per output.", default=4, at_least=1, at_most=8)
    input_format: Fixed = param("1", "Format of the input.", default=Fixed(4))
    output_format: Fixed = param("1", "Format of the output.", default=Fixed(16, 12))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of the output.", default="saturate")
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to decimate.", dtype=FixedValue)

    sums = Buffer("Integrators, the first at the input.", FixedValue, ("order",))
    before = Buffer("Values of the combs in the output before.", FixedValue, ("order",))


class State(NamedTuple):
    phase: FixedValue
    finished: FixedValue


def word(p: FixedCascadedIntegratorComb) -> Fixed:
    """Format of the integrators and combs."""
    return Fixed(p.input_format.width + p.order * p.bits, p.input_format.fraction)


@FixedCascadedIntegratorComb.formats
def formats(p: FixedCascadedIntegratorComb) -> dict[str, Fixed]:
    registers = {"sums": word(p), "before": word(p), "x.phase": Fixed(p.bits, signed=False)}
    return registers | {"input": p.input_format, "x.finished": p.output_format, "output": p.output_format}


@FixedCascadedIntegratorComb.output("{unit}", every=lambda p: 1 << p.bits)
def output(p: FixedCascadedIntegratorComb, x: State) -> FixedValue:
    """The filtered signal, from the inputs before this tick; its gain is 1 at rest."""
    return x.finished


@FixedCascadedIntegratorComb.update
def update(
    p: FixedCascadedIntegratorComb, x: State, sums: list[FixedValue], before: list[FixedValue], input: FixedValue
) -> State:
    carried = input
    for k in range(len(sums)):
        sums[k] = carried = (sums[k] + carried).to(word(p), "floor", "wrap")
    last = x.phase == (1 << p.bits) - 1
    for k in range(len(before)):
        difference = (carried - before[k]).to(word(p), "floor", "wrap")
        before[k] = where(last, carried, before[k])
        carried = difference
    shifted = FixedValue(carried.mantissa, p.input_format.fraction + p.order * p.bits)
    finished = where(last, shifted.to(p.output_format, p.rounding, p.overflow), x.finished)
    return State((x.phase + 1).to(Fixed(p.bits, signed=False), "floor", "wrap"), finished)
