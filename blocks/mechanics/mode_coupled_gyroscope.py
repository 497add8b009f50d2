"""Two modes: m x'' + cx x' + cxy y' + kx x + kxy y = Fx + 2 k m W y', and for y with Fy - 2 k m W x'.

x is the drive mode, y the sense mode, W the rotation, k the angular gain between them: 1 for a mass
that moves as a whole, n times Bryan's factor of a ring whose waves are n around it. kxy = 2 k m wx
Wq makes quadrature, in phase with x and as large as that of the rate Wq; cxy = 2 k m Wd,
anisodamping, cannot be told from a rate (IEEE Std 1431).
"""

import math

from proofmass.blocks.arithmetic.two_modes import Coupling, Motion, rate_of_change
from proofmass.blocks.declaration.declare import Block, Input, param


class ModeCoupledGyroscope(Block):
    """Vibratory gyroscope with the errors of its suspension. Wire the rate to `rotation`: it is held over a tick."""

    mass: float = param("kg", "Modal mass of both modes, m.", default=5e-8, above=0.0)
    drive_frequency: float = param("Hz", "Resonance of the drive mode.", default=8000.0, above=0.0)
    drive_quality: float = param("1", "Quality factor of the drive mode.", default=1000.0, above=0.0)
    sense_frequency: float = param("Hz", "Resonance of the sense mode.", default=8200.0, above=0.0)
    sense_quality: float = param("1", "Quality factor of the sense mode.", default=1000.0, above=0.0)
    angular_gain: float = param(
        "1", "Coupling by rotation, k: 1 for a mass that moves as a whole.", default=1.0, at_least=-1.0, at_most=1.0
    )
    rotation: float = param("rad/s", "Rate of rotation, W.", default=0.0)
    quadrature_rate: float = param("rad/s", "Rate whose force is as large as quadrature, Wq.", default=0.0)
    damping_rate: float = param("rad/s", "Rate whose force is that of anisodamping, Wd.", default=0.0)

    drive_force = Input("N", "Force on the drive mode, Fx.")
    sense_force = Input("N", "Force on the sense mode, Fy.", default=0.0)


@ModeCoupledGyroscope.constants
def constants(p: ModeCoupledGyroscope, period: float) -> Coupling:
    wx, wy = 2.0 * math.pi * p.drive_frequency, 2.0 * math.pi * p.sense_frequency
    twice = 2.0 * p.angular_gain
    kxy, cxy = twice * wx * p.quadrature_rate, twice * p.damping_rate
    cx, cy = wx / p.drive_quality, wy / p.sense_quality
    return Coupling(p.mass, wx * wx, cx, wy * wy, cy, kxy, cxy, twice * p.rotation)


@ModeCoupledGyroscope.output("m")
def drive_displacement(c: Coupling, x: Motion) -> float:
    """Displacement of the drive mode."""
    return x.x


@ModeCoupledGyroscope.output("m/s")
def drive_velocity(c: Coupling, x: Motion) -> float:
    """Velocity of the drive mode."""
    return x.vx


@ModeCoupledGyroscope.output("m")
def sense_displacement(c: Coupling, x: Motion) -> float:
    """Displacement of the sense mode."""
    return x.y


@ModeCoupledGyroscope.output("m/s")
def sense_velocity(c: Coupling, x: Motion) -> float:
    """Velocity of the sense mode."""
    return x.vy


@ModeCoupledGyroscope.derivative(linear=True)
def derivative(c: Coupling, x: Motion, drive_force: float, sense_force: float) -> Motion:
    return rate_of_change(c, x, drive_force, sense_force)
