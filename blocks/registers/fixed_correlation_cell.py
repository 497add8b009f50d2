"""Correlation cell in registers: h[lag] = (sum of b[n-lag] y[n]) / (N + 1) over N = 2^order - 1 chips b = +1 or -1.

A multiplexer takes y or -y, an accumulator sums, and a shift by the order divides (Sarraf et al.
2012, section 2.1, Fig. 2d). What it gives lacks a constant, the sum of the response over N + 1, as
every cell does.
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding, where
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param

CHIP = Fixed(2)  # +1, -1, or 0 before the start


class FixedCorrelationCell(Block):
    """One coefficient of an impulse response in fixed point; a value per period, from the tick after its last chip."""

    lag: int = param("1", "Which coefficient: chips between cause and response.", default=1, at_least=1, at_most=64)
    order: int = param("1", "Cells of the shift register.", default=10, at_least=2, at_most=16)
    input_format: Fixed = param("1", "Format of the response.", default=Fixed(16, 12))
    output_format: Fixed = param("1", "Format of the coefficient.", default=Fixed(16, 12))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of the output.", default="saturate")
    unit: str = param("", "Unit of the response.", default="V")

    bit = Input("1", "Chip that excites the device.", dtype=bool)
    response = Input("{unit}", "Response of the device in the same tick.", dtype=FixedValue)

    history = Buffer("Chips before, newest first.", FixedValue, ("lag",))


class State(NamedTuple):
    chip: FixedValue
    total: FixedValue
    finished: FixedValue


@FixedCorrelationCell.formats
def formats(p: FixedCorrelationCell) -> dict[str, Fixed]:
    return {
        "response": p.input_format,
        "history": CHIP,
        "x.chip": Fixed(p.order, signed=False),
        "x.total": total_format(p),
        "x.finished": p.output_format,
        "coefficient": p.output_format,
    }


def total_format(p: FixedCorrelationCell) -> Fixed:
    """Format of a sum that no period overflows."""
    return Fixed(p.input_format.width + p.order, p.input_format.fraction)


@FixedCorrelationCell.output("{unit}", every=lambda p: (1 << p.order) - 1)
def coefficient(p: FixedCorrelationCell, x: State) -> FixedValue:
    """Coefficient of the last whole period; 0 in the first one."""
    return x.finished


@FixedCorrelationCell.update
def update(p: FixedCorrelationCell, x: State, history: list[FixedValue], bit: bool, response: FixedValue) -> State:
    total = (x.total + history[-1] * response).to(total_format(p))
    for k in range(len(history) - 1, 0, -1):
        history[k] = history[k - 1]
    history[0] = where(bit, FixedValue(1), FixedValue(-1))
    if x.chip < (1 << p.order) - 2:
        return State((x.chip + 1).to(Fixed(p.order, signed=False)), total, x.finished)
    divided = FixedValue(total.mantissa, p.input_format.fraction + p.order)
    return State(
        FixedValue(0), FixedValue(0, p.input_format.fraction), divided.to(p.output_format, p.rounding, p.overflow)
    )
