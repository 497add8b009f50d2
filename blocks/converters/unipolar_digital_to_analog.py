"""Unipolar digital-to-analog converter: voltage = clip(rint(number)) reference / 2^bits, held over the period.

As DA0 of the digital quartz accelerometer, V = N_VREF K_DA0 with K_DA0 = reference / 2^bits (eq.
30).
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import round_half_even, saturated
from proofmass.blocks.declaration.declare import Block, Input, param


class UnipolarDigitalToAnalog(Block):
    """Converter of codes from 0 on: an adjustable voltage reference."""

    bits: int = param("bit", "Resolution.", default=20, at_least=2, at_most=32)
    reference: float = param("V", "Voltage of the code 2^bits: the span.", default=5.0, above=0.0)

    number = Input("1", "Number to convert; rounded half to even and saturated.")


class Constants(NamedTuple):
    lsb: float
    highest: float


@UnipolarDigitalToAnalog.constants
def constants(p: UnipolarDigitalToAnalog, period: float) -> Constants:
    codes = float(1 << p.bits)
    return Constants(p.reference * (1.0 / codes), codes - 1.0)


@UnipolarDigitalToAnalog.output("1")
def code(c: Constants, number: float) -> int:
    """Code that is converted."""
    return int(round_half_even(saturated(number, 0.0, c.highest)))


@UnipolarDigitalToAnalog.output("V")
def voltage(c: Constants, number: float) -> float:
    """Voltage of the code."""
    return round_half_even(saturated(number, 0.0, c.highest)) * c.lsb
