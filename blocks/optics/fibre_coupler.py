"""Fibre coupler: through = t ((1 - k) P1 + k P2 + B), cross = t (k P1 + (1 - k) P2 - B), t the transmission.

B = 2 coherence sqrt(k (1 - k) P1 P2) sin(phase): a wave that crosses falls behind by a quarter
turn, and so what interference adds to one output the other lacks (Saleh and Teich, Fundamentals of
Photonics, section 8.5). The phase is that by which the second wave is ahead of the first.
"""

import math

from proofmass.blocks.arithmetic.elementary import sine
from proofmass.blocks.declaration.declare import Block, Input, param


class FibreCoupler(Block):
    """Two fibres that share their light: splitter of a source, or mixer of its waves."""

    coupling: float = param("1", "Part of the power that crosses, k.", default=0.5, at_least=0.0, at_most=1.0)
    transmission: float = param("1", "Power out over power in, t.", default=1.0, at_least=0.0, at_most=1.0)
    coherence: float = param(
        "1", "Contrast of the interference of both inputs.", default=1.0, at_least=0.0, at_most=1.0
    )

    first = Input("W", "Power P1 into the first fibre; none below zero.")
    second = Input("W", "Power P2 into the second fibre; none below zero.", default=0.0)
    phase = Input("rad", "Phase by which the second wave is ahead of the first.", default=0.0)


def interference(p: FibreCoupler, first: float, second: float, phase: float) -> float:
    """B, zero where one input is dark."""
    product = p.coupling * (1.0 - p.coupling) * first * second
    return 2.0 * p.coherence * (math.sqrt(product) if product > 0.0 else 0.0) * sine(phase)


@FibreCoupler.output("W")
def through(p: FibreCoupler, first: float, second: float, phase: float) -> float:
    """Power out of the first fibre."""
    a, b = first if first > 0.0 else 0.0, second if second > 0.0 else 0.0
    return p.transmission * ((1.0 - p.coupling) * a + p.coupling * b + interference(p, a, b, phase))


@FibreCoupler.output("W")
def cross(p: FibreCoupler, first: float, second: float, phase: float) -> float:
    """Power out of the second fibre."""
    a, b = first if first > 0.0 else 0.0, second if second > 0.0 else 0.0
    return p.transmission * (p.coupling * a + (1.0 - p.coupling) * b - interference(p, a, b, phase))


@FibreCoupler.corner
def first_above_zero(p: FibreCoupler, first: float) -> float:
    return first


@FibreCoupler.corner
def second_above_zero(p: FibreCoupler, second: float) -> float:
    return second
