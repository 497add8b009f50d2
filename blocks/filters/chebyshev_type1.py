"""Chebyshev filter of type 1: |H|^2 = 1 / (1 + e^2 Tn(W)^2), W = tan(pi f T) / tan(pi fc T), or 1 / W as high-pass.

e^2 = 10^(ripple / 10) - 1. The poles of the prototype are -sinh(m) sin(a) + j cosh(m) cos(a), m = asinh(1 / e) / n,
a = (2k + 1) pi / (2n) (Oppenheim and Schafer, Discrete-Time Signal Processing, appendix B).
"""

import math

from proofmass.blocks.arithmetic.elementary import (
    cosine_of_turns,
    exponential_less_one,
    hyperbolic_cosine,
    hyperbolic_sine,
    logarithm_of_one_plus,
    sine_of_turns,
)
from proofmass.blocks.arithmetic.sections import (
    LARGEST_ORDER,
    Delays,
    Poles,
    Sections,
    designed,
    filtered,
    moved,
    warped,
)
from proofmass.blocks.declaration.declare import Block, Input, param


class ChebyshevType1(Block):
    """Digital low-pass or high-pass that is steeper than a Butterworth filter, for ripples below the corner."""

    order: int = param("1", "Number of poles.", default=4, at_least=1, at_most=LARGEST_ORDER)
    corner_frequency: float = param("Hz", "Where the ripple ends.", default=100.0, above=0.0)
    ripple: float = param("1", "Ripple of the passband in decibels.", default=0.5, above=0.0, at_most=20.0)
    high_pass: bool = param("", "Whether it passes what is above the corner.", default=False)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "What is filtered.")


@ChebyshevType1.constants
def constants(p: ChebyshevType1, period: float) -> Sections:
    square = exponential_less_one(0.23025850929940458 * p.ripple)  # 10^(ripple / 10) - 1
    steep = 1.0 / math.sqrt(square)
    bend = logarithm_of_one_plus(steep + steep * steep / (1.0 + math.sqrt(1.0 + steep * steep))) / p.order  # asinh
    w1, q1 = pole(0, p.order, bend)
    w2, q2 = pole(1, p.order, bend)
    w3, q3 = pole(2, p.order, bend)
    w4, q4 = pole(3, p.order, bend)
    gain = 1.0 if p.order % 2 == 1 else 1.0 / math.sqrt(1.0 + square)
    corner = warped(p.corner_frequency, period)
    return designed(Poles(w1, q1, w2, q2, w3, q3, w4, q4), p.order, p.high_pass, corner, gain)


def pole(pair: int, order: int, bend: float) -> tuple[float, float]:
    """Radius and quality of a pole pair, counted from the imaginary axis; of any number beyond the order."""
    turns = (2 * pair + 1) / (4 * order) if 2 * pair < order else 0.25
    real = hyperbolic_sine(bend) * sine_of_turns(turns)
    imaginary = hyperbolic_cosine(bend) * cosine_of_turns(turns) if 2 * pair + 1 < order else 0.0
    radius = math.sqrt(real * real + imaginary * imaginary)
    return radius, 0.5 * radius / real


@ChebyshevType1.output("{unit}")
def output(c: Sections, x: Delays, input: float) -> float:
    """The filtered signal."""
    return filtered(c, x, input)


@ChebyshevType1.update
def update(c: Sections, x: Delays, input: float) -> Delays:
    return moved(c, x, input)
