"""Vibrating ring or hemisphere: the two modes of n = 2 nodes, whose principal axes need not be the electrodes':

    x'' - 2 k W y' + cx x' + cxy y' + (w^2 - d cos 2t) x - d sin 2t y = Fx / m
    y'' + 2 k W x' + cxy x' + cy y' - d sin 2t x + (w^2 + d cos 2t) y = Fy / m

k is the angular gain, W the rate, d = w dw with dw the difference of the frequencies and t the angle of the softer
axis from x; cx = 2/T + D cos 2s, cy = 2/T - D cos 2s, cxy = D sin 2s with time constant T, and D the difference of 1/T
along and across the angle s (Lynch, Vibratory gyro analysis by the method of averaging, 1995).
"""

import math

from proofmass.blocks.arithmetic.elementary import cosine, sine
from proofmass.blocks.arithmetic.two_modes import Coupling, Motion, rate_of_change
from proofmass.blocks.declaration.declare import Block, Input, param


class VibratingRing(Block):
    """Axisymmetric gyroscope, for rate or whole angle: its pattern turns by -k times the angle of the case."""

    mass: float = param("kg", "Modal mass, m.", default=1e-7, above=0.0)
    frequency: float = param("Hz", "Mean frequency of both modes.", default=14_000.0, above=0.0)
    time_constant: float = param("s", "Time in which an amplitude falls to 1/e, T.", default=1.0, above=0.0)
    angular_gain: float = param("1", "Bryan's factor, k: 0.37 of a ring.", default=0.37, at_least=-1.0, at_most=1.0)
    frequency_split: float = param("Hz", "Difference of the frequencies of the modes.", default=0.0)
    split_angle: float = param("rad", "Angle t, in the plane of x and y, of the axis of lower frequency.", default=0.0)
    damping_split: float = param("1/s", "Difference of the inverse time constants, D.", default=0.0)
    damping_angle: float = param("rad", "Angle s of the axis of more damping.", default=0.0)
    rotation: float = param("rad/s", "Rate of rotation, W.", default=0.0)

    x_force = Input("N", "Force on the first mode, Fx.")
    y_force = Input("N", "Force on the second mode, Fy.", default=0.0)


@VibratingRing.constants
def constants(p: VibratingRing, period: float) -> Coupling:
    w = 2.0 * math.pi * p.frequency
    d = w * 2.0 * math.pi * p.frequency_split
    decay = 2.0 / p.time_constant
    along, across = cosine(2.0 * p.split_angle), sine(2.0 * p.split_angle)
    more, between = p.damping_split * cosine(2.0 * p.damping_angle), p.damping_split * sine(2.0 * p.damping_angle)
    coriolis = 2.0 * p.angular_gain * p.rotation
    kx, ky = w * w - d * along, w * w + d * along
    return Coupling(p.mass, kx, decay + more, ky, decay - more, -d * across, between, coriolis)


@VibratingRing.output("m")
def x_displacement(c: Coupling, x: Motion) -> float:
    """Displacement of the first mode."""
    return x.x


@VibratingRing.output("m/s")
def x_velocity(c: Coupling, x: Motion) -> float:
    """Velocity of the first mode."""
    return x.vx


@VibratingRing.output("m")
def y_displacement(c: Coupling, x: Motion) -> float:
    """Displacement of the second mode."""
    return x.y


@VibratingRing.output("m/s")
def y_velocity(c: Coupling, x: Motion) -> float:
    """Velocity of the second mode."""
    return x.vy


@VibratingRing.derivative(linear=True)
def derivative(c: Coupling, x: Motion, x_force: float, y_force: float) -> Motion:
    return rate_of_change(c, x, x_force, y_force)
