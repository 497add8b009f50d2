"""Digital-to-analog converter: voltage = clip(rint(number)) reference / 2^(bits-1), held over the period.

(Digital quartz accelerometer, eq. 9 and 29.)
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import round_half_even, saturated
from proofmass.blocks.declaration.declare import Block, Input, param


class DigitalToAnalog(Block):
    """Bipolar digital-to-analog converter; drive `reference` for one that drifts."""

    bits: int = param("bit", "Resolution.", default=20, at_least=2, at_most=32)
    reference: float = param("V", "Voltage of the code 2^(bits-1): half the span.", default=2.5, above=0.0)

    number = Input("1", "Number to convert; rounded half to even and saturated.")


class Constants(NamedTuple):
    lsb: float
    lowest: float
    highest: float


@DigitalToAnalog.constants
def constants(p: DigitalToAnalog, period: float) -> Constants:
    half = float(1 << (p.bits - 1))
    return Constants(p.reference * (1.0 / half), -half, half - 1.0)


@DigitalToAnalog.output("1")
def code(c: Constants, number: float) -> int:
    """Code that is converted."""
    return int(round_half_even(saturated(number, c.lowest, c.highest)))


@DigitalToAnalog.output("V")
def voltage(c: Constants, number: float) -> float:
    """Voltage of the code."""
    return round_half_even(saturated(number, c.lowest, c.highest)) * c.lsb
