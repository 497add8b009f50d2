"""Butterworth filter of order n: |H|^2 = 1 / (1 + W^(2n)), W = tan(pi f T) / tan(pi fc T), or 1 / W as high-pass.

The poles of the prototype are at radius 1 and quality 1 / (2 sin((2k + 1) pi / (2n))) (Butterworth,
On the theory of filter amplifiers, 1930). At the corner fc the response is down by 3 dB; at most it
is half the rate.
"""

from proofmass.blocks.arithmetic.prototypes import LARGEST_ORDER, butterworth
from proofmass.blocks.arithmetic.sections import Sections, designed, output, update, warped
from proofmass.blocks.declaration.declare import Block, Input, param


class Butterworth(Block):
    """Digital low-pass or high-pass of flattest response: anti-aliasing, output bandwidth."""

    order: int = param("1", "Number of poles.", default=2, at_least=1, at_most=LARGEST_ORDER)
    corner_frequency: float = param("Hz", "Frequency at which it is down by 3 dB.", default=100.0, above=0.0)
    high_pass: bool = param("", "Whether it passes what is above the corner.", default=False)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to filter.")


@Butterworth.constants
def constants(p: Butterworth, period: float) -> Sections:
    return designed(butterworth(p.order), p.order, p.high_pass, warped(p.corner_frequency, period))


Butterworth.output("{unit}")(output)
Butterworth.update(update)
