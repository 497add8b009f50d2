"""Chebyshev filter of type 1: |H|^2 = 1 / (1 + e^2 Tn(W)^2), W = tan(pi f T) / tan(pi fc T), or 1 / W as high-pass.

e^2 = 10^(ripple / 10) - 1. The poles of the prototype are -sinh(m) sin(a) + j cosh(m) cos(a), m = asinh(1 / e) / n,
a = (2k + 1) pi / (2n) (Oppenheim and Schafer, Discrete-Time Signal Processing, appendix B).
"""

from proofmass.blocks.arithmetic.prototypes import LARGEST_ORDER, chebyshev_type1
from proofmass.blocks.arithmetic.sections import Sections, designed, output, update, warped
from proofmass.blocks.declaration.declare import Block, Input, param


class ChebyshevType1(Block):
    """Digital low-pass or high-pass that is steeper than a Butterworth filter, for ripples below the corner."""

    order: int = param("1", "Number of poles.", default=4, at_least=1, at_most=LARGEST_ORDER)
    corner_frequency: float = param("Hz", "Frequency at which the ripple ends.", default=100.0, above=0.0)
    ripple: float = param("1", "Ripple of the passband in decibels.", default=0.5, above=0.0, at_most=20.0)
    high_pass: bool = param("", "Whether it passes what is above the corner.", default=False)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to filter.")


@ChebyshevType1.constants
def constants(p: ChebyshevType1, period: float) -> Sections:
    return designed(chebyshev_type1(p.order, p.ripple), p.order, p.high_pass, warped(p.corner_frequency, period))


ChebyshevType1.output("{unit}")(output)
ChebyshevType1.update(update)
