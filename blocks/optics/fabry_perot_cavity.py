"""Fabry-Perot cavity under phase-modulated light: F(f) = (r2 e^(j p) - r1) / (1 - r1 r2 e^(j p)), p = 4 pi L f / c.

The field is e^(j depth sin(W t)), W = 2 pi modulation_frequency: a carrier of Pc = J0(depth)^2 P,
two sidebands of Ps = J1(depth)^2 P each. Of what comes back, `reflected` is the mean over a period
of the modulation, and `error` the peak in phase with sin(W t): 2 sqrt(Pc Ps) Im(F(f) F*(f + fm) -
F*(f) F(f - fm)) (Black, Am. J. Phys. 69, 79, 2001, eq. 3.3). At resonance it falls by 8 sqrt(Pc Ps)
per full width at half maximum, if r1 = r2 and fm is far above that. Quasi-static: f must change
slowly against the width, and a loop be slow against fm.
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import cosine, sine
from proofmass.blocks.declaration.declare import Block, Input, param

SPEED_OF_LIGHT = 299_792_458.0  # m/s, exact in the SI


class FabryPerotCavity(Block):
    """Light that two mirrors send back: the error signal of a Pound-Drever-Hall lock, a fringe of high finesse."""

    length: float = param("m", "Distance of the mirrors, L.", default=250e-6, above=0.0)
    front_reflectivity: float = param("1", "Of power, r1^2.", default=0.997, above=0.0, below=1.0)
    back_reflectivity: float = param("1", "Of power, with all losses, r2^2.", default=0.997, above=0.0, at_most=1.0)
    modulation_frequency: float = param("Hz", "Frequency of the sidebands, fm.", default=5e9, above=0.0)
    modulation_depth: float = param("rad", "Peak of the phase.", default=1.08, at_least=0.0, at_most=3.0)

    detuning = Input("Hz", "Frequency of the laser above that of the cavity, f.")
    power = Input("W", "Light on the front mirror, P.")


class Constants(NamedTuple):
    front: float
    back: float
    turn: float  # of a round trip, rad/Hz
    carrier: float
    sideband: float
    cosine: float  # of the turn of the modulation's frequency
    sine: float


def bessel(order: int, depth: float) -> float:
    """J0 or J1 by its series; 20 terms are exact to rounding up to 3."""
    total = term = 0.5 * depth if order == 1 else 1.0
    for k in range(1, 20):
        term = -term * 0.25 * depth * depth / (k * (k + order))
        total += term
    return total


@FabryPerotCavity.constants
def constants(p: FabryPerotCavity, period: float) -> Constants:
    turn = 4.0 * math.pi * p.length / SPEED_OF_LIGHT
    front, back = math.sqrt(p.front_reflectivity), math.sqrt(p.back_reflectivity)
    carrier, sideband = bessel(0, p.modulation_depth), bessel(1, p.modulation_depth)
    angle = turn * p.modulation_frequency
    return Constants(front, back, turn, carrier, sideband, cosine(angle), sine(angle))


def size(c: Constants, co: float) -> float:
    """|1 - r1 r2 e^(j p)|^2 by the cosine of p, without the loss of digits near resonance."""
    product = c.front * c.back
    return (1.0 - product) * (1.0 - product) + 2.0 * product * (1.0 - co)


def part(c: Constants, co: float) -> float:
    """|F|^2 by the cosine of p."""
    return ((c.back - c.front) * (c.back - c.front) + 2.0 * c.front * c.back * (1.0 - co)) / size(c, co)


@FabryPerotCavity.output("W")
def reflected(c: Constants, detuning: float, power: float) -> float:
    """Mean power that comes back."""
    co, si = cosine(c.turn * detuning), sine(c.turn * detuning)
    sides = part(c, co * c.cosine - si * c.sine) + part(c, co * c.cosine + si * c.sine)
    return power * (c.carrier * c.carrier * part(c, co) + c.sideband * c.sideband * sides)


@FabryPerotCavity.output("W")
def error(c: Constants, detuning: float, power: float) -> float:
    """Peak of the power at the modulation's frequency, in phase with its sine."""
    co, si = cosine(c.turn * detuning), sine(c.turn * detuning)
    upper, lower = co * c.cosine - si * c.sine, co * c.cosine + si * c.sine
    product, turned = c.front * c.back, c.back * (1.0 - c.front * c.front)  # Im F = turned sin(p) / size
    along, against = c.back * (1.0 + c.front * c.front), c.front * (1.0 + c.back * c.back)
    here, above, below = size(c, co), size(c, upper), size(c, lower)
    real = (along * upper - against) / above + (along * lower - against) / below  # both sidebands
    imaginary = 2.0 * turned * si * ((1.0 + product * product) * c.cosine - 2.0 * product * co) / (above * below)
    beat = turned * si * real - (along * co - against) * imaginary
    return 2.0 * power * c.carrier * c.sideband * beat / here
