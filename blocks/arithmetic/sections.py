"""Digital filters of order 1 to 8 as four sections of second order, designed from an analog prototype.

A section is y = b0 u + s, s' = b1 u - a1 y + t, t' = b2 u - a2 y (transposed direct form II). A
pole pair of the prototype at radius w with quality q, and its zeros at radius 1 / z on the
imaginary axis, become one by the bilinear transform, warped so that the corner stays where it is
(Oppenheim and Schafer, Discrete-Time Signal Processing, section 7.1).
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import tangent
from proofmass.blocks.arithmetic.prototypes import Prototype

HIGHEST = 0.4999999  # corner over rate at most: beyond half the rate there is no signal


class Sections(NamedTuple):
    """Coefficients of four sections, one after the other; those that the order does not need copy their input."""

    b10: float
    b11: float
    b12: float
    a11: float
    a12: float
    b20: float
    b21: float
    b22: float
    a21: float
    a22: float
    b30: float
    b31: float
    b32: float
    a31: float
    a32: float
    b40: float
    b41: float
    b42: float
    a41: float
    a42: float


class Delays(NamedTuple):
    """s and t of four sections."""

    s1: float
    t1: float
    s2: float
    t2: float
    s3: float
    t3: float
    s4: float
    t4: float


def warped(frequency: float, period: float) -> float:
    """tan(pi frequency period): the corner of the analog filter, in half rates."""
    turns = frequency * period
    return tangent(math.pi * (turns if turns < HIGHEST else HIGHEST))


def designed(prototype: Prototype, order: int, high: bool, corner: float) -> Sections:
    """Sections of a low-pass or, with poles and zeros reflected at the circle, a high-pass."""
    p, gain = prototype, prototype.gain
    b10, b11, b12, a11, a12 = _section(0, order, high, corner, p.w1, p.q1, p.z1)
    b20, b21, b22, a21, a22 = _section(1, order, high, corner, p.w2, p.q2, p.z2)
    b30, b31, b32, a31, a32 = _section(2, order, high, corner, p.w3, p.q3, p.z3)
    b40, b41, b42, a41, a42 = _section(3, order, high, corner, p.w4, p.q4, p.z4)
    return Sections(
        gain * b10, gain * b11, gain * b12, a11, a12, b20, b21, b22, a21, a22,
        b30, b31, b32, a31, a32, b40, b41, b42, a41, a42,
    )  # fmt: skip


def _section(
    index: int, order: int, high: bool, corner: float, w: float, q: float, z: float
) -> tuple[float, float, float, float, float]:
    if 2 * index >= order:
        return 1.0, 0.0, 0.0, 0.0, 0.0
    k = corner / w if high else corner * w
    side = -1.0 if high else 1.0
    if 2 * index + 1 == order:
        b0 = (1.0 if high else k) / (1.0 + k)
        return b0, side * b0, 0.0, (k - 1.0) / (k + 1.0), 0.0
    scale = 1.0 / (1.0 + k / q + k * k)
    ratio = corner * z if high else z / corner  # of the zeros to the corner's tangent, or inverse
    top = (1.0 if high else k * k) * scale
    b0 = top * (1.0 + ratio * ratio)
    b1 = side * 2.0 * (top * (1.0 - ratio * ratio))
    return b0, b1, b0, 2.0 * (k * k - 1.0) * scale, (1.0 - k / q + k * k) * scale


def settled(c: Sections, u: float) -> Delays:
    """Return the delays after an input that has been the same for ever."""
    y1 = (c.b10 + c.b11 + c.b12) / (1.0 + c.a11 + c.a12) * u
    y2 = (c.b20 + c.b21 + c.b22) / (1.0 + c.a21 + c.a22) * y1
    y3 = (c.b30 + c.b31 + c.b32) / (1.0 + c.a31 + c.a32) * y2
    y4 = (c.b40 + c.b41 + c.b42) / (1.0 + c.a41 + c.a42) * y3
    return Delays(
        y1 - c.b10 * u,
        c.b12 * u - c.a12 * y1,
        y2 - c.b20 * y1,
        c.b22 * y1 - c.a22 * y2,
        y3 - c.b30 * y2,
        c.b32 * y2 - c.a32 * y3,
        y4 - c.b40 * y3,
        c.b42 * y3 - c.a42 * y4,
    )


def output(c: Sections, x: Delays, input: float) -> float:
    """The filtered signal."""
    return c.b40 * (c.b30 * (c.b20 * (c.b10 * input + x.s1) + x.s2) + x.s3) + x.s4


def update(c: Sections, x: Delays, input: float) -> Delays:
    """The delays of the next tick."""
    y1 = c.b10 * input + x.s1
    y2 = c.b20 * y1 + x.s2
    y3 = c.b30 * y2 + x.s3
    y4 = c.b40 * y3 + x.s4
    return Delays(
        c.b11 * input - c.a11 * y1 + x.t1,
        c.b12 * input - c.a12 * y1,
        c.b21 * y1 - c.a21 * y2 + x.t2,
        c.b22 * y1 - c.a22 * y2,
        c.b31 * y2 - c.a31 * y3 + x.t3,
        c.b32 * y2 - c.a32 * y3,
        c.b41 * y3 - c.a41 * y4 + x.t4,
        c.b42 * y3 - c.a42 * y4,
    )
