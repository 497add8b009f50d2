"""Mode of a beam under an axial force N: m x'' + m w0 / Q x' + m w0^2 (1 + N / Nc) x = F, f = f0 sqrt(1 + N / Nc).

Nc is the force at which the beam buckles under pressure; tension is positive. Of a beam clamped at both ends
Nc = 3.40 E b h^3 / L^2, f0 = 1.028 h / L^2 sqrt(E / rho) (Albert, Vibrating quartz crystal beam accelerometer, 1982).
"""

import math
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class ResonantBeam(Block):
    """Force sensor of frequency output. Wire the axial force to `axial_force`: it is held over a tick of its source."""

    mass: float = param("kg", "Modal mass, m.", default=1e-9, above=0.0)
    frequency: float = param("Hz", "Resonance without axial force, f0.", default=40_000.0, above=0.0)
    quality: float = param("1", "Quality factor, Q.", default=10_000.0, above=0.0)
    axial_force: float = param("N", "Axial force N, positive for tension.", default=0.0)
    critical_force: float = param("N", "Euler's buckling force, Nc.", default=1.0, above=0.0)

    force = Input("N", "Force of the drive on the mode.")


class State(NamedTuple):
    displacement: float
    velocity: float


class Constants(NamedTuple):
    mass: float
    decay: float  # 1/s
    square: float  # of the angular frequency


@ResonantBeam.constants
def constants(p: ResonantBeam, period: float) -> Constants:
    w = 2.0 * math.pi * p.frequency
    return Constants(p.mass, w / p.quality, w * w * (1.0 + p.axial_force / p.critical_force))


@ResonantBeam.output("m")
def displacement(c: Constants, x: State) -> float:
    """Displacement of the mode."""
    return x.displacement


@ResonantBeam.output("m/s")
def velocity(c: Constants, x: State) -> float:
    """Velocity of the mode."""
    return x.velocity


@ResonantBeam.derivative(linear=True)
def derivative(c: Constants, x: State, force: float) -> State:
    return State(x.velocity, force / c.mass - c.decay * x.velocity - c.square * x.displacement)
