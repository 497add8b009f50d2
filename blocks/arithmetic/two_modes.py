"""Two modes of one mass that stiffness, damping and rotation couple, all over the mass:

    x'' + cx x' + cxy y' + kx x + kxy y = Fx / m + w y'
    y'' + cy y' + cxy x' + ky y + kxy x = Fy / m - w x'

w is twice the angular gain times the rate of rotation (IEEE Std 1431; Lynch, Vibratory gyro
analysis by the method of averaging, 1995).
"""

from typing import NamedTuple


class Motion(NamedTuple):
    """Displacements and velocities."""

    x: float
    vx: float
    y: float
    vy: float


class Coupling(NamedTuple):
    """The mass, and what acts on it over the mass."""

    mass: float
    kx: float
    cx: float
    ky: float
    cy: float
    kxy: float
    cxy: float
    coriolis: float  # w


def rate_of_change(c: Coupling, x: Motion, x_force: float, y_force: float) -> Motion:
    """Velocities and accelerations."""
    ax = x_force / c.mass - c.cx * x.vx - c.kx * x.x - c.kxy * x.y + (c.coriolis - c.cxy) * x.vy
    ay = y_force / c.mass - c.cy * x.vy - c.ky * x.y - c.kxy * x.x - (c.coriolis + c.cxy) * x.vx
    return Motion(x.vx, ax, x.vy, ay)
