"""Analog elliptic low-pass: poles j cd((u - j v) K, k), zeros j / (k cd(u K, k)), u = (2i + 1) / n;
edge at 1 rad/s.

e_p^2 = 10^(ripple / 10) - 1, e_s^2 = 10^(attenuation / 10) - 1, k1 = e_p / e_s; the nome of k is
the n-th root of that of k1; sn(j n v K1, k1) = j / e_p. Jacobi's functions follow from Landen
transformations (Orfanidis, Lecture Notes on Elliptic Filter Design, 2006; Abramowitz and Stegun,
16.12, 17.3).
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import (
    cosine_of_turns,
    exponential,
    exponential_less_one,
    hyperbolic_cosine,
    hyperbolic_sine,
    logarithm_of_one_plus,
    sine_of_turns,
)
from proofmass.blocks.arithmetic.prototypes import PER_DECIBEL, Prototype, turns_of

STEPS = 12  # of an arithmetic-geometric mean; each doubles the digits
TERMS = 16  # of a theta series


class Moduli(NamedTuple):
    """A modulus after 1 to 7 Landen transformations, each about half the last one squared."""

    k1: float
    k2: float
    k3: float
    k4: float
    k5: float
    k6: float
    k7: float


def elliptic(order: int, ripple: float, attenuation: float) -> Prototype:
    """Poles and zeros for a ripple of the passband and an attenuation beyond it, in decibels."""
    passed, stopped = exponential_less_one(PER_DECIBEL * ripple), exponential_less_one(PER_DECIBEL * attenuation)
    k1 = math.sqrt(passed / stopped)
    complement = math.sqrt((1.0 - k1) * (1.0 + k1))
    nome = exponential(-math.pi * mean(1.0, complement) / (mean(1.0, k1) * order))
    k, other = modulus(nome)
    bend = _unfolded(1.0 / math.sqrt(passed), k1, complement) / order
    moduli = landen(k, other)
    w1, q1, z1 = _pair(0, order, bend, k, moduli)
    w2, q2, z2 = _pair(1, order, bend, k, moduli)
    w3, q3, z3 = _pair(2, order, bend, k, moduli)
    w4, q4, z4 = _pair(3, order, bend, k, moduli)
    gain = 1.0 if order % 2 == 1 else 1.0 / math.sqrt(1.0 + passed)
    return Prototype(gain, w1, q1, z1, w2, q2, z2, w3, q3, z3, w4, q4, z4)


def mean(a: float, g: float) -> float:
    """The arithmetic-geometric mean: K(k) = pi / (2 mean(1, k')).

    >>> round(mean(1.0, 2.0**0.5), 15)
    1.198140234735592
    """
    for _ in range(STEPS):
        a, g = 0.5 * (a + g), math.sqrt(a * g)
    return 0.5 * (a + g)


def modulus(nome: float) -> tuple[float, float]:
    """The modulus k = (theta2 / theta3)^2 and its complement k' = (theta4 / theta3)^2.

    >>> k, other = modulus(math.exp(-math.pi))
    >>> round(k, 14), round(other, 14)
    (0.70710678118655, 0.70710678118655)
    """
    second, third, fourth = 1.0, 1.0, 1.0
    square, oblong, step, sign = 1.0, 1.0, nome, -1.0
    for _ in range(TERMS):
        square *= step  # q^(m^2)
        oblong *= step * nome  # q^(m (m + 1)), as step is q^(2m - 1)
        oblong_now = oblong
        second += oblong_now
        third += 2.0 * square
        fourth += 2.0 * sign * square
        sign = -sign
        step *= nome * nome
    second = second / third
    fourth = fourth / third
    return 4.0 * math.sqrt(nome) * second * second, fourth * fourth


def landen(k: float, complement: float) -> Moduli:
    """Descending moduli."""
    k1, c1 = _descended(k, complement)
    k2, c2 = _descended(k1, c1)
    k3, c3 = _descended(k2, c2)
    k4, c4 = _descended(k3, c3)
    k5, c5 = _descended(k4, c4)
    k6, c6 = _descended(k5, c5)
    k7, _ = _descended(k6, c6)
    return Moduli(k1, k2, k3, k4, k5, k6, k7)


def _descended(k: float, complement: float) -> tuple[float, float]:
    root = k / (1.0 + complement)
    return root * root, 2.0 * math.sqrt(complement) / (1.0 + complement)


def _unfolded(value: float, k: float, complement: float) -> float:
    """v pi / 2 of sn(j v K, k) = j value."""
    for _ in range(7):
        following, other = _descended(k, complement)
        value = 2.0 * value / ((1.0 + following) * (1.0 + math.sqrt(1.0 + k * k * value * value)))
        k, complement = following, other
    return logarithm_of_one_plus(value + value * value / (1.0 + math.sqrt(1.0 + value * value)))


def _pair(pair: int, order: int, bend: float, k: float, moduli: Moduli) -> tuple[float, float, float]:
    """Radius, quality and one over the radius of the zeros of a pole pair."""
    turns = turns_of(pair, order)
    real = cosine_of_turns(turns)
    x, y = real * hyperbolic_cosine(bend), sine_of_turns(turns) * hyperbolic_sine(bend)
    x, y = _ascended(moduli, x, y)
    zero, _ = _ascended(moduli, real, 0.0)
    radius = math.sqrt(x * x + y * y)
    return radius, 0.5 * radius / y, k * zero


def _ascended(moduli: Moduli, x: float, y: float) -> tuple[float, float]:
    """cd of what cos(pi u / 2) = x + j y."""
    x, y = _step(moduli.k7, x, y)
    x, y = _step(moduli.k6, x, y)
    x, y = _step(moduli.k5, x, y)
    x, y = _step(moduli.k4, x, y)
    x, y = _step(moduli.k3, x, y)
    x, y = _step(moduli.k2, x, y)
    return _step(moduli.k1, x, y)


def _step(k: float, x: float, y: float) -> tuple[float, float]:
    """(1 + k) w / (1 + k w^2), w = x + j y."""
    c, d = 1.0 + k * (x * x - y * y), 2.0 * k * x * y
    scale = (1.0 + k) / (c * c + d * d)
    return scale * (x * c + y * d), scale * (y * c - x * d)
