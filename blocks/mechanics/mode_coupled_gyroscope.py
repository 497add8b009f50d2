"""Two modes: m x'' + cx x' + cxy y' + kx x + kxy y = Fx + 2 k m W y', and for y with Fy - 2 k m W x'.

x is the drive mode, y the sense mode, W the rotation, k the angular gain. kxy = 2 k m wx Wq makes quadrature, in phase
with x and as large as that of the rate Wq; cxy = 2 k m Wd, anisodamping, cannot be told from a rate (IEEE Std 1431).
"""

import math
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class ModeCoupledGyroscope(Block):
    """Vibratory gyroscope with the errors of its suspension. Wire the rate to `rotation`: it is held over a tick."""

    mass: float = param("kg", "Modal mass of both modes, m.", default=5e-8, above=0.0)
    drive_frequency: float = param("Hz", "Resonance of the drive mode.", default=8000.0, above=0.0)
    drive_quality: float = param("1", "Quality factor of the drive mode.", default=1000.0, above=0.0)
    sense_frequency: float = param("Hz", "Resonance of the sense mode.", default=8200.0, above=0.0)
    sense_quality: float = param("1", "Quality factor of the sense mode.", default=1000.0, above=0.0)
    angular_gain: float = param("1", "Part of the mass that turns, k.", default=1.0, at_least=-1.0, at_most=1.0)
    rotation: float = param("rad/s", "Rate of rotation, W.", default=0.0)
    quadrature_rate: float = param("rad/s", "Rate whose force is as large as quadrature, Wq.", default=0.0)
    damping_rate: float = param("rad/s", "Rate whose force is that of anisodamping, Wd.", default=0.0)

    drive_force = Input("N", "Force on the drive mode, Fx.")
    sense_force = Input("N", "Force on the sense mode, Fy.", default=0.0)


class State(NamedTuple):
    x: float
    vx: float
    y: float
    vy: float


class Constants(NamedTuple):
    mass: float
    kx: float  # all over the mass
    cx: float
    ky: float
    cy: float
    kxy: float
    cxy: float
    coriolis: float


@ModeCoupledGyroscope.constants
def constants(p: ModeCoupledGyroscope, period: float) -> Constants:
    wx, wy = 2.0 * math.pi * p.drive_frequency, 2.0 * math.pi * p.sense_frequency
    twice = 2.0 * p.angular_gain
    kxy, cxy = twice * wx * p.quadrature_rate, twice * p.damping_rate
    cx, cy = wx / p.drive_quality, wy / p.sense_quality
    return Constants(p.mass, wx * wx, cx, wy * wy, cy, kxy, cxy, twice * p.rotation)


@ModeCoupledGyroscope.output("m")
def drive_displacement(c: Constants, x: State) -> float:
    """Displacement of the drive mode."""
    return x.x


@ModeCoupledGyroscope.output("m/s")
def drive_velocity(c: Constants, x: State) -> float:
    """Velocity of the drive mode."""
    return x.vx


@ModeCoupledGyroscope.output("m")
def sense_displacement(c: Constants, x: State) -> float:
    """Displacement of the sense mode."""
    return x.y


@ModeCoupledGyroscope.output("m/s")
def sense_velocity(c: Constants, x: State) -> float:
    """Velocity of the sense mode."""
    return x.vy


@ModeCoupledGyroscope.derivative(linear=True)
def derivative(c: Constants, x: State, drive_force: float, sense_force: float) -> State:
    ax = drive_force / c.mass - c.cx * x.vx - c.kx * x.x - c.kxy * x.y + (c.coriolis - c.cxy) * x.vy
    ay = sense_force / c.mass - c.cy * x.vy - c.ky * x.y - c.kxy * x.x - (c.coriolis + c.cxy) * x.vx
    return State(x.vx, ax, x.vy, ay)
