"""Digital band-pass and band-stop filters of order 2 to 8 from an analog prototype of order 1 to 4.

s becomes (s^2 + w0^2) / (b s), or one over that, with w0^2 = t1 t2, b = t2 - t1, t = tan(pi f T),
so that a pole pair of the prototype becomes two, at x + sqrt(x^2 - w0^2), x = p b / 2, and at w0^2
over that; zeros do alike. The bilinear transform follows (Oppenheim and Schafer, Discrete-Time
Signal Processing, section 7.1).
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.prototypes import Prototype
from proofmass.blocks.arithmetic.sections import Sections, warped

LARGEST_BAND_ORDER = 4


class Digital(NamedTuple):
    """Coefficients of one section."""

    b0: float
    b1: float
    b2: float
    a1: float
    a2: float


def banded(prototype: Prototype, order: int, stop: bool, low: float, high: float, period: float) -> Sections:
    """The sections of the band between two frequencies; the order is that of the prototype."""
    p, gain = prototype, prototype.gain
    t1, t2 = warped(low, period), warped(high, period)
    one, two = _pair(0, order, stop, t1, t2, p.w1, p.q1, p.z1)
    three, four = _pair(1, order, stop, t1, t2, p.w2, p.q2, p.z2)
    return Sections(
        gain * one.b0, gain * one.b1, gain * one.b2, one.a1, one.a2, two.b0, two.b1, two.b2, two.a1, two.a2,
        three.b0, three.b1, three.b2, three.a1, three.a2, four.b0, four.b1, four.b2, four.a1, four.a2,
    )  # fmt: skip


def _pair(
    index: int, order: int, stop: bool, t1: float, t2: float, w: float, q: float, z: float
) -> tuple[Digital, Digital]:
    """Two sections of a pole pair, one of a real pole; the others copy their input."""
    if 2 * index >= order:
        return Digital(1.0, 0.0, 0.0, 0.0, 0.0), Digital(1.0, 0.0, 0.0, 0.0, 0.0)
    square, b = t1 * t2, t2 - t1
    reach = b / w if stop else b * w
    if 2 * index + 1 == order:
        top = _digital(1.0, 0.0, square, reach, square) if stop else _digital(0.0, reach, 0.0, reach, square)
        return top, Digital(1.0, 0.0, 0.0, 0.0, 0.0)
    real, imaginary = _upper(0.5 * reach, q, square)
    high = real * real + imaginary * imaginary
    share = square / high
    if not stop and z == 0.0:
        return (
            _digital(0.0, reach, 0.0, -2.0 * real, high),
            _digital(0.0, reach, 0.0, -2.0 * real * share, square * share),
        )
    half = 0.5 * (b * z if stop else b / z)
    zero = half + math.sqrt(half * half + square)
    gain, zeros = 1.0 if stop else w * z, zero * zero
    return (
        _digital(gain, 0.0, gain * zeros, -2.0 * real, high),
        _digital(gain, 0.0, gain * square * (square / zeros), -2.0 * real * share, square * share),
    )


def _upper(radius: float, q: float, square: float) -> tuple[float, float]:
    """x + sqrt(x^2 - square), x = radius (-1 / (2q) + j sqrt(1 - 1 / (2q)^2)); the root of the same signs as x."""
    part = 0.5 / q
    x, y = -radius * part, radius * math.sqrt((1.0 - part) * (1.0 + part))
    real, imaginary = (x - y) * (x + y) - square, 2.0 * x * y
    size = math.sqrt(real * real + imaginary * imaginary)
    if real < 0.0:
        up = math.sqrt(0.5 * (size - real))
        return x + 0.5 * imaginary / up, y + up
    across = -math.sqrt(0.5 * (size + real))
    return x + across, y + 0.5 * imaginary / across


def _digital(n2: float, n1: float, n0: float, d1: float, d0: float) -> Digital:
    """(n2 s^2 + n1 s + n0) / (s^2 + d1 s + d0), s = (z - 1) / (z + 1)."""
    scale = 1.0 / (1.0 + d1 + d0)
    return Digital(
        scale * (n2 + n1 + n0),
        scale * 2.0 * (n0 - n2),
        scale * (n2 - n1 + n0),
        scale * 2.0 * (d0 - 1.0),
        scale * (1.0 - d1 + d0),
    )
