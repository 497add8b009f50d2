"""Mode of a beam under an axial force N: m x'' + m w0 / Q x' + m w0^2 (1 + N / Nc) x = F, f = f0 sqrt(1 + N / Nc).

Tension is positive, and Nc is the slope's: m w0^2 over the change of stiffness per force. Of a beam
clamped at both ends Nc = 3.39 E b h^3 / L^2, f0 = 1.028 h / L^2 sqrt(E / rho) (Albert, Vibrating
quartz crystal beam accelerometer, 1982, has 3.40). That is 3 % above Euler's load, 3.29, at which
it buckles, since its shape under load is another. A beam hinged at both ends has one and the same,
0.822.
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
    critical_force: float = param(
        "N", "Force that would take all stiffness off, Nc: 1.03 times Euler's if clamped.", default=1.0, above=0.0
    )

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
