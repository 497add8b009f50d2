"""Chebyshev filter of type 2: |H|^2 = 1 / (1 + 1 / (e^2 Tn(1 / W)^2)), W = tan(pi f T) / tan(pi fc T), or 1 / W.

e^2 = 1 / (10^(attenuation / 10) - 1). The poles of the prototype are one over those of type 1, its zeros at
1 / cos((2k + 1) pi / (2n)) (Oppenheim and Schafer, Discrete-Time Signal Processing, appendix B).
"""

from proofmass.blocks.arithmetic.prototypes import LARGEST_ORDER, chebyshev_type2
from proofmass.blocks.arithmetic.sections import Sections, designed, output, update, warped
from proofmass.blocks.declaration.declare import Block, Input, param


class ChebyshevType2(Block):
    """Digital low-pass or high-pass that is flat where it passes, and stops by so many decibels from the corner on."""

    order: int = param("1", "Number of poles.", default=4, at_least=1, at_most=LARGEST_ORDER)
    corner_frequency: float = param("Hz", "Frequency at which the attenuation is reached.", default=100.0, above=0.0)
    attenuation: float = param(
        "1", "Decibels by which what is stopped is down, at least.", default=40.0, above=0.0, at_most=200.0
    )
    high_pass: bool = param("", "Whether it passes what is above the corner.", default=False)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to filter.")


@ChebyshevType2.constants
def constants(p: ChebyshevType2, period: float) -> Sections:
    return designed(chebyshev_type2(p.order, p.attenuation), p.order, p.high_pass, warped(p.corner_frequency, period))


ChebyshevType2.output("{unit}")(output)
ChebyshevType2.update(update)
