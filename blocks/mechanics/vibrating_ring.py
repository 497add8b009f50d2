"""Vibrating ring or hemisphere: its two modes of number n, whose principal axes need not be the electrodes':

    x'' - 2 n k W y' + cx x' + cxy y' + (w^2 - d cos 2t) x - d sin 2t y = Fx / m
    y'' + 2 n k W x' + cxy x' + cy y' - d sin 2t x + (w^2 + d cos 2t) y = Fy / m

The shell moves outwards by x cos n a + y sin n a at the angle a around it, so that an angle in the
plane of x and y is n times that on the shell. W is the rate, far below w, and k is Bryan's factor:
a wave that vibrates freely lags behind the shell by k times the angle that the case turns through.
That of a thin ring is 2/(n^2 + 1).
d = w dw with dw the difference of the frequencies and t the modal angle of the softer axis from x;
cx = 2/T + D cos 2s, cy = 2/T - D cos 2s, cxy = D sin 2s with time constant T, and D the difference
of 1/T along and across the modal angle s (Bryan, On the beats in the vibrations of a revolving
cylinder or bell, 1890; Lynch, Vibratory gyro analysis by the method of averaging, 1995).
"""

import math

from proofmass.blocks.arithmetic.elementary import cosine, sine
from proofmass.blocks.arithmetic.two_modes import Coupling, Motion, rate_of_change
from proofmass.blocks.declaration.declare import Block, Input, param


class VibratingRing(Block):
    """Axisymmetric gyroscope, for rate or whole angle: its wave turns on the shell by -k of the angle of the case."""

    mass: float = param("kg", "Modal mass, m.", default=1e-7, above=0.0)
    frequency: float = param("Hz", "Mean frequency of both modes.", default=14_000.0, above=0.0)
    time_constant: float = param("s", "Time in which an amplitude falls to 1/e, T.", default=1.0, above=0.0)
    angular_gain: float = param(
        "1",
        "Bryan's factor on the shell, k: 0.4 of a thin ring with n = 2, 0.27 to 0.31 of hemispheres.",
        default=0.37,
        at_least=-1.0,
        at_most=1.0,
    )
    mode_number: int = param("1", "Waves around the shell, n.", default=2, at_least=2, at_most=100)
    frequency_split: float = param("Hz", "Difference of the frequencies of the modes.", default=0.0)
    split_angle: float = param("rad", "Modal angle t of the softer axis: n times that on the shell.", default=0.0)
    damping_split: float = param("1/s", "Difference of the inverse time constants, D.", default=0.0)
    damping_angle: float = param("rad", "Modal angle s of the axis of more damping.", default=0.0)
    rotation: float = param("rad/s", "Rate of rotation, W.", default=0.0)
    initial_x_displacement: float = param("m", "Displacement at the start.", default=0.0)
    initial_y_displacement: float = param("m", "Displacement at the start.", default=0.0)

    x_force = Input("N", "Force on the first mode, Fx.")
    y_force = Input("N", "Force on the second mode, Fy.", default=0.0)


@VibratingRing.constants
def constants(p: VibratingRing, period: float) -> Coupling:
    w = 2.0 * math.pi * p.frequency
    d = w * 2.0 * math.pi * p.frequency_split
    decay = 2.0 / p.time_constant
    along, across = cosine(2.0 * p.split_angle), sine(2.0 * p.split_angle)
    more, between = p.damping_split * cosine(2.0 * p.damping_angle), p.damping_split * sine(2.0 * p.damping_angle)
    coriolis = 2.0 * p.mode_number * p.angular_gain * p.rotation
    kx, ky = w * w - d * along, w * w + d * along
    return Coupling(p.mass, kx, decay + more, ky, decay - more, -d * across, between, coriolis)


@VibratingRing.start
def start(p: VibratingRing) -> Motion:
    return Motion(p.initial_x_displacement, 0.0, p.initial_y_displacement, 0.0)


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
