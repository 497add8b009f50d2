"""Elements of the ellipse in which two degenerate modes vibrate, from the components of both along sine and cosine.

Modes x = cx sin f + sx cos f and y = cy sin f + sy cos f move along an ellipse: half axes a and q,
with a at the angle g from x, and the phase f + d. D. D. Lynch's variables (Vibratory gyro analysis
by the method of averaging, 1995) are

    E = cx^2 + sx^2 + cy^2 + sy^2 = a^2 + q^2              Q = 2 (cx sy - cy sx) = 2 a q
    R = cx^2 + sx^2 - cy^2 - sy^2 = (a^2 - q^2) cos 2g     S = 2 (cx cy + sx sy) = (a^2 - q^2) sin 2g
    L = 2 (cx sx + cy sy) = (a^2 - q^2) sin 2d

They know g and d up to half a turn. Here d is from -pi/2 to pi/2, and g is that of a vector (cx,
cy) from there.
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import arctangent2, cosine, sine
from proofmass.blocks.declaration.declare import Block, Input, param


class VibrationEllipse(Block):
    """Amplitude, quadrature, angle and phase of a ring's or shell's wave, but a circle."""

    unit: str = param("", "Unit of signal and components.", default="V")
    mode_number: int = param("1", "Waves around the shell, n.", default=2, at_least=2, at_most=100)

    x_in_phase = Input("{unit}", "Component of the first mode along the sine, cx.")
    x_quadrature = Input("{unit}", "Component of the first mode along the cosine, sx.")
    y_in_phase = Input("{unit}", "Component of the second mode along the sine, cy.")
    y_quadrature = Input("{unit}", "Component of the second mode along the cosine, sy.")


class Axes(NamedTuple):
    major: float
    minor: float


def half_axes(cx: float, sx: float, cy: float, sy: float) -> Axes:
    """Half axes a >= |q|: their sum and difference are the roots of E + Q and E - Q, sums of two squares each."""
    total = math.sqrt((cx + sy) * (cx + sy) + (sx - cy) * (sx - cy))
    rest = math.sqrt((cx - sy) * (cx - sy) + (sx + cy) * (sx + cy))
    major = 0.5 * (total + rest)
    return Axes(major, (cx * sy - cy * sx) / major if major > 0.0 else 0.0)


def angle_of_axis(cx: float, sx: float, cy: float, sy: float) -> float:
    """Angle of the long axis from the first mode in the modal plane, -pi to pi, beside (cx, cy)."""
    half = 0.5 * arctangent2(2.0 * (cx * cy + sx * sy), cx * cx + sx * sx - cy * cy - sy * sy)
    if cx * cosine(half) + cy * sine(half) >= 0.0:
        return half
    return half + math.pi if half <= 0.0 else half - math.pi


@VibrationEllipse.output("{unit}")
def amplitude(
    p: VibrationEllipse, x_in_phase: float, x_quadrature: float, y_in_phase: float, y_quadrature: float
) -> float:
    """Half of the long axis, a."""
    return half_axes(x_in_phase, x_quadrature, y_in_phase, y_quadrature).major


@VibrationEllipse.output("{unit}")
def quadrature(
    p: VibrationEllipse, x_in_phase: float, x_quadrature: float, y_in_phase: float, y_quadrature: float
) -> float:
    """Half of the short axis, q; above zero if the short axis, at a right angle, leads."""
    return half_axes(x_in_phase, x_quadrature, y_in_phase, y_quadrature).minor


@VibrationEllipse.output("rad")
def modal_angle(
    p: VibrationEllipse, x_in_phase: float, x_quadrature: float, y_in_phase: float, y_quadrature: float
) -> float:
    """Electrical angle of the pattern, g: from the first mode in the plane of both, -pi to pi."""
    return angle_of_axis(x_in_phase, x_quadrature, y_in_phase, y_quadrature)


@VibrationEllipse.output("rad")
def pattern_angle(
    p: VibrationEllipse, x_in_phase: float, x_quadrature: float, y_in_phase: float, y_quadrature: float
) -> float:
    """Angle of the pattern on the shell, g / n: -pi/n to pi/n."""
    return angle_of_axis(x_in_phase, x_quadrature, y_in_phase, y_quadrature) / float(p.mode_number)


@VibrationEllipse.output("rad")
def phase(p: VibrationEllipse, x_in_phase: float, x_quadrature: float, y_in_phase: float, y_quadrature: float) -> float:
    """Phase by which the vibration leads the sine, d: -pi/2 to pi/2."""
    cx, sx, cy, sy = x_in_phase, x_quadrature, y_in_phase, y_quadrature
    return 0.5 * arctangent2(2.0 * (cx * sx + cy * sy), cx * cx + cy * cy - sx * sx - sy * sy)
