"""Fibre coil: phase[n] = 2 pi L D / (wavelength c) rotation[n] + modulation[n] - modulation[n - transit].

The two waves through the coil pass the modulator at its end `transit` ticks apart: L index / c in
time (Lefevre, The Fiber-Optic Gyroscope, 2014, chapters 2 and 3).
"""

import math
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Buffer, Input, param

SPEED_OF_LIGHT = 299_792_458.0  # m/s, exact in the SI


class SagnacCoil(Block):
    """Phase difference of the two waves of a fibre-optic gyroscope, with its modulator."""

    length: float = param("m", "Length of the fibre, L.", default=1000.0, above=0.0)
    diameter: float = param("m", "Diameter of the coil, D.", default=0.1, above=0.0)
    wavelength: float = param("m", "Wavelength of the light in vacuum.", default=1.55e-6, above=0.0)
    transit: int = param("1", "Ticks that light takes through the coil.", default=10, at_least=1, at_most=100_000)

    rotation = Input("rad/s", "Rate of rotation about the axis of the coil.")
    modulation = Input("rad", "Phase that the modulator gives to light that passes it.", default=0.0)

    line = Buffer("Modulation of the last ticks.", float, ("transit",))


class State(NamedTuple):
    oldest: int  # its place in the line


class Constants(NamedTuple):
    scale: float  # s


@SagnacCoil.constants
def constants(p: SagnacCoil, period: float) -> Constants:
    return Constants(2.0 * math.pi * p.length * p.diameter / (p.wavelength * SPEED_OF_LIGHT))


@SagnacCoil.output("rad")
def phase(c: Constants, x: State, line: list[float], rotation: float, modulation: float) -> float:
    """Phase difference of the two waves."""
    return c.scale * rotation + (modulation - line[x.oldest])


@SagnacCoil.update
def update(c: Constants, x: State, line: list[float], modulation: float) -> State:
    line[x.oldest] = modulation
    return State(x.oldest + 1 if x.oldest + 1 < len(line) else 0)
