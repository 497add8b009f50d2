"""Integral nonlinearity: output = v + lsb (bow (1 - x^2) + s_shape 3 sqrt(3) / 2 (x - x^3)), x = v / reference.

Zero at both ends of the span, bow at its middle, s_shape at x = 1 / sqrt(3): the second and third
order of what data sheets show; lsb = reference / 2^(bits-1). The best-fit line is not taken off
(IEEE Std 1241, section 6).
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import saturated
from proofmass.blocks.declaration.declare import Block, Input, param


class IntegralNonlinearity(Block):
    """Bent characteristic of a converter, in its own steps: before an AnalogToDigital or behind a DigitalToAnalog."""

    bits: int = param("bit", "Resolution of the converter.", default=16, at_least=2, at_most=32)
    reference: float = param("V", "Half the span.", default=2.5, above=0.0)
    bow: float = param("1", "Largest error of second order, in steps.", default=1.0)
    s_shape: float = param("1", "Largest error of third order, in steps.", default=1.0)

    voltage = Input("V", "Ideal voltage.")


class Constants(NamedTuple):
    reference: float
    bow: float  # V
    s_shape: float  # V


@IntegralNonlinearity.constants
def constants(p: IntegralNonlinearity, period: float) -> Constants:
    lsb = p.reference / float(1 << (p.bits - 1))
    return Constants(p.reference, p.bow * lsb, p.s_shape * 2.598076211353316 * lsb)


@IntegralNonlinearity.output("V")
def output(c: Constants, voltage: float) -> float:
    """The voltage with its error; beyond the span there is none."""
    x = saturated(voltage / c.reference, -1.0, 1.0)
    return voltage + (1.0 - x * x) * (c.bow + c.s_shape * x)


@IntegralNonlinearity.corner
def above_lowest(c: Constants, voltage: float) -> float:
    return voltage + c.reference


@IntegralNonlinearity.corner
def above_highest(c: Constants, voltage: float) -> float:
    return voltage - c.reference
