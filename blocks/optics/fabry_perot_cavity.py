"""Fabry-Perot cavity under phase-modulated light: F(f) = (r2 e^(j p) - r1) / (1 - r1 r2 e^(j p)), p = 4 pi L f / c.

The field is e^(j depth sin(W t)), W = 2 pi modulation_frequency: a carrier of Pc = J0(depth)^2 P, two sidebands of
Ps = J1(depth)^2 P each. Of what comes back, `reflected` is the mean over a period of the modulation. `cosine` and
`sine` are peaks at W: 2 sqrt(Pc Ps) times Re and Im of F(f) F*(f + fm) - F*(f) F(f - fm) (Black, Am. J. Phys. 69, 79,
2001, eq. 3.3). At resonance `sine` falls by 8 sqrt(Pc Ps) per full width at half maximum, if r1 = r2 and fm is far
above that. Quasi-static: f must change slowly against the width, and a loop be slow against fm.
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import cosine as cosine_of
from proofmass.blocks.arithmetic.elementary import sine as sine_of
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
    power = Input("W", "Light on the front mirror, P; none below zero.")


class Constants(NamedTuple):
    front: float
    back: float
    turn: float  # of a round trip, rad/Hz
    carrier: float
    sideband: float
    cosine: float  # of the turn of the modulation's frequency
    sine: float


class Field(NamedTuple):
    real: float
    imaginary: float


class Fields(NamedTuple):
    """Real and imaginary part of F at the carrier, the upper and the lower sideband."""

    x: float
    y: float
    upper_x: float
    upper_y: float
    lower_x: float
    lower_y: float


def bessel(order: int, depth: float) -> float:
    """J0 or J1 by its series; 20 terms are exact to rounding up to 3."""
    term = 0.5 * depth if order == 1 else 1.0
    total = term
    for k in range(1, 20):
        term = -term * 0.25 * depth * depth / (k * (k + order))
        total += term
    return total


@FabryPerotCavity.constants
def constants(p: FabryPerotCavity, period: float) -> Constants:
    turn = 4.0 * math.pi * p.length / SPEED_OF_LIGHT
    mirrors = math.sqrt(p.front_reflectivity), math.sqrt(p.back_reflectivity)
    light = bessel(0, p.modulation_depth), bessel(1, p.modulation_depth)
    angle = turn * p.modulation_frequency
    return Constants(mirrors[0], mirrors[1], turn, light[0], light[1], cosine_of(angle), sine_of(angle))


def field(c: Constants, co: float, si: float) -> Field:
    """F of a unit field by cosine and sine of the phase of a round trip."""
    top, up = c.back * co - c.front, c.back * si
    down, low = 1.0 - c.front * c.back * co, c.front * c.back * si
    size = down * down + low * low
    return Field((top * down - up * low) / size, (top * low + up * down) / size)


def fields(c: Constants, detuning: float) -> Fields:
    co, si = cosine_of(c.turn * detuning), sine_of(c.turn * detuning)
    a = field(c, co, si)
    b = field(c, co * c.cosine - si * c.sine, si * c.cosine + co * c.sine)
    d = field(c, co * c.cosine + si * c.sine, si * c.cosine - co * c.sine)
    return Fields(a.real, a.imaginary, b.real, b.imaginary, d.real, d.imaginary)


@FabryPerotCavity.output("W")
def reflected(c: Constants, detuning: float, power: float) -> float:
    """Mean power that comes back."""
    f = fields(c, detuning)
    sides = f.upper_x * f.upper_x + f.upper_y * f.upper_y + f.lower_x * f.lower_x + f.lower_y * f.lower_y
    part = c.carrier * c.carrier * (f.x * f.x + f.y * f.y) + c.sideband * c.sideband * sides
    return part * power if power > 0.0 else 0.0


@FabryPerotCavity.output("W")
def cosine(c: Constants, detuning: float, power: float) -> float:
    """Amplitude at the modulation's frequency, in phase with its cosine."""
    f = fields(c, detuning)
    part = f.x * (f.upper_x - f.lower_x) + f.y * (f.upper_y - f.lower_y)
    return 2.0 * c.carrier * c.sideband * part * power if power > 0.0 else 0.0


@FabryPerotCavity.output("W")
def sine(c: Constants, detuning: float, power: float) -> float:
    """Amplitude at the modulation's frequency, in phase with its sine: the error signal."""
    f = fields(c, detuning)
    part = f.y * (f.upper_x + f.lower_x) - f.x * (f.upper_y + f.lower_y)
    return 2.0 * c.carrier * c.sideband * part * power if power > 0.0 else 0.0


@FabryPerotCavity.corner
def power_above_zero(c: Constants, power: float) -> float:
    return power
