"""Measured nonlinearity: output = v + lsb e(v), e the errors at equally spaced voltages, with straight lines between.

The first error is that at -reference, the last that at +reference; beyond them the end errors hold.
lsb is reference / 2^(bits-1) (IEEE Std 1241, section 6).
"""

import math
from collections.abc import Iterator

from proofmass.blocks.arithmetic.rounding import clip
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class MeasuredNonlinearity(Block):
    """Integral nonlinearity as measured: before an AnalogToDigital or after a DigitalToAnalog."""

    bits: int = param("bit", "Resolution of the converter.", default=16, at_least=2, at_most=32)
    reference: float = param("V", "Half the span.", default=2.5, above=0.0)
    errors: tuple[float, ...] = param("1", "Errors in steps, from one end to the other.", default=(0.0, 1.0, 0.0))

    voltage = Input("V", "Ideal voltage.")

    table = Buffer("The errors.", float, ("errors",))


@MeasuredNonlinearity.requires
def requires(p: MeasuredNonlinearity) -> Iterator[tuple[str, str]]:
    if len(p.errors) < 2:
        yield "errors", "two numbers or more"


@MeasuredNonlinearity.start
def start(p: MeasuredNonlinearity, table: list[float]) -> None:
    table[:] = p.errors


@MeasuredNonlinearity.output("V")
def output(p: MeasuredNonlinearity, table: list[float], voltage: float) -> float:
    """The voltage with its error."""
    spaces = len(table) - 1
    place = clip(0.5 * (voltage / p.reference + 1.0), 0.0, 1.0) * float(spaces)
    i = math.floor(place)
    i = i if i < spaces else spaces - 1
    error = table[i] + (place - float(i)) * (table[i + 1] - table[i])
    return voltage + error * (p.reference / float(1 << (p.bits - 1)))
