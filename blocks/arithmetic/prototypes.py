"""Analog low-pass filters by name: poles, zeros and gain of order 1 to 8, with their corner at 1 rad/s.

Pole pairs are counted from the imaginary axis, pair k at the angle a = (2k + 1) pi / (2n). Of an
odd order the last is one real pole. Formulas: Butterworth, On the theory of filter amplifiers,
1930; Thomson, Proc. IEE 96, 1949; Oppenheim and Schafer, Discrete-Time Signal Processing, appendix
B.
"""

import math
from itertools import cycle, islice
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import (
    cosine_of_turns,
    exponential_less_one,
    hyperbolic_cosine,
    hyperbolic_sine,
    logarithm_of_one_plus,
    sine_of_turns,
)

LARGEST_ORDER = 8
PER_DECIBEL = 0.23025850929940458  # ln(10) / 10

# Radius and quality of each pole pair, and radius of the real pole, for each order: of the polynomial's roots.
_ROWS = (
    (1.0,),
    (1.272019649514069, 0.5773502691896257),
    (1.4476171331469874, 0.6910466258250713, 1.3226757999104448),
    (1.603357516216973, 0.8055382818416658, 1.4301715599939906, 0.5219345816689802),
    (1.7553777766370968, 0.9164773739482478, 1.5563471222969236, 0.5635356208514565, 1.502316271447479),
    (1.9047076123027622, 1.023313953826724, 1.6891682676204605, 0.6111945468780026,
     1.6039191287737986, 0.51031782474877),
    (2.0494909002691073, 1.126257541983041, 1.8224174788579959, 0.6608213892970801,
     1.7163560448708648, 0.5323556978995465, 1.6843681792731802),
    (2.188726230527439, 1.2256694254081706, 1.9531957590220648, 0.710852074441698,
     1.8320926011985827, 0.5596091647957911, 1.778465911774649, 0.50599106939747),
)  # fmt: skip
TABLE = tuple(number for row in _ROWS for number in islice(cycle(row), 8))  # those beyond the order are never read


class Prototype(NamedTuple):
    """Gain at rest, and radius w and quality q of each pole pair with one over the radius of its zeros, z.

    z is 0 where the zeros are at infinity. A real pole has no quality.
    """

    gain: float
    w1: float
    q1: float
    z1: float
    w2: float
    q2: float
    z2: float
    w3: float
    q3: float
    z3: float
    w4: float
    q4: float
    z4: float


def butterworth(order: int) -> Prototype:
    """Poles at radius 1 and quality 1 / (2 sin a)."""
    return Prototype(
        1.0, 1.0, _flat(0, order), 0.0, 1.0, _flat(1, order), 0.0, 1.0, _flat(2, order), 0.0, 1.0, _flat(3, order), 0.0
    )


def bessel(order: int) -> Prototype:
    """Roots of the reverse Bessel polynomial, scaled to -3 dB at 1 rad/s."""
    i = 8 * (order - 1)
    return Prototype(
        1.0, TABLE[i], TABLE[i + 1], 0.0, TABLE[i + 2], TABLE[i + 3], 0.0,
        TABLE[i + 4], TABLE[i + 5], 0.0, TABLE[i + 6], TABLE[i + 7], 0.0,
    )  # fmt: skip


def chebyshev_type1(order: int, ripple: float) -> Prototype:
    """-sinh(m) sin(a) + j cosh(m) cos(a), m = asinh(1 / e) / n, e^2 = 10^(ripple / 10) - 1."""
    square = exponential_less_one(PER_DECIBEL * ripple)
    bend = _area_sine(1.0 / math.sqrt(square)) / order
    w1, q1 = _on_ellipse(0, order, bend)
    w2, q2 = _on_ellipse(1, order, bend)
    w3, q3 = _on_ellipse(2, order, bend)
    w4, q4 = _on_ellipse(3, order, bend)
    gain = 1.0 if order % 2 == 1 else 1.0 / math.sqrt(1.0 + square)
    return Prototype(gain, w1, q1, 0.0, w2, q2, 0.0, w3, q3, 0.0, w4, q4, 0.0)


def chebyshev_type2(order: int, attenuation: float) -> Prototype:
    """One over the poles of type 1 with e^2 = 1 / (10^(attenuation / 10) - 1), and zeros at 1 / cos a."""
    bend = _area_sine(math.sqrt(exponential_less_one(PER_DECIBEL * attenuation))) / order
    w1, q1 = _on_ellipse(0, order, bend)
    w2, q2 = _on_ellipse(1, order, bend)
    w3, q3 = _on_ellipse(2, order, bend)
    w4, q4 = _on_ellipse(3, order, bend)
    z1, z2, z3, z4 = _cosine(0, order), _cosine(1, order), _cosine(2, order), _cosine(3, order)
    return Prototype(1.0, 1.0 / w1, q1, z1, 1.0 / w2, q2, z2, 1.0 / w3, q3, z3, 1.0 / w4, q4, z4)


def turns_of(pair: int, order: int) -> float:
    """The angle of a pole pair from the imaginary axis, in turns; that of the real axis for any beyond the order."""
    return min(2 * pair + 1, order) / (4 * order)


def _flat(pair: int, order: int) -> float:
    return 0.5 / sine_of_turns(turns_of(pair, order))


def _cosine(pair: int, order: int) -> float:
    return cosine_of_turns(turns_of(pair, order))


def _on_ellipse(pair: int, order: int, bend: float) -> tuple[float, float]:
    """Radius and quality of a pole of Chebyshev."""
    real = hyperbolic_sine(bend) * sine_of_turns(turns_of(pair, order))
    imaginary = hyperbolic_cosine(bend) * _cosine(pair, order)
    radius = math.sqrt(real * real + imaginary * imaginary)
    return radius, 0.5 * radius / real


def _area_sine(value: float) -> float:
    """asinh of a positive number."""
    return logarithm_of_one_plus(value + value * value / (1.0 + math.sqrt(1.0 + value * value)))
