"""Analog-to-digital converter: code = clip(rint((gain v + offset) 2^(bits-1) / reference)).

Rounding is to the nearest code, ties to even; saturation at -2^(bits-1) and 2^(bits-1) - 1
(Sarraf et al. 2012, section 3.2; digital quartz accelerometer, eq. 7).
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.arithmetic.rounding import round_half_even, saturated
from proofmass.blocks.declaration.declare import Block, Input, param


class AnalogToDigital(Block):
    """Bipolar analog-to-digital converter."""

    bits: int = param("bit", "Resolution.", default=12, at_least=2, at_most=32)
    reference: float = param("V", "Voltage of the code 2^(bits-1): half the span.", default=10.0, above=0.0)
    offset_error: float = param("V", "Voltage added before the conversion.", default=0.0)
    gain_error: float = param("1", "Relative error of the gain.", default=0.0, above=-1.0)

    voltage = Input("V", "Voltage to convert.")


class Constants(NamedTuple):
    codes_per_volt: float
    offset: float
    lowest: float
    highest: float


@AnalogToDigital.formats
def formats(p: AnalogToDigital) -> dict[str, Fixed]:
    return {"code": Fixed(p.bits)}


@AnalogToDigital.constants
def constants(p: AnalogToDigital, period: float) -> Constants:
    half = float(1 << (p.bits - 1))
    codes_per_volt = half / p.reference
    return Constants(codes_per_volt * (1.0 + p.gain_error), codes_per_volt * p.offset_error, -half, half - 1.0)


@AnalogToDigital.output("1")
def code(c: Constants, voltage: float) -> int:
    """Output code, for digital blocks."""
    return int(round_half_even(saturated(c.codes_per_volt * voltage + c.offset, c.lowest, c.highest)))


@AnalogToDigital.output("1")
def number(c: Constants, voltage: float) -> float:
    """Output code as a number, for blocks that compute with numbers."""
    return round_half_even(saturated(c.codes_per_volt * voltage + c.offset, c.lowest, c.highest))
