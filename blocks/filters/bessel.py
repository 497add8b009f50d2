"""Bessel filter of order n: H(s) = B(0) / B(s / w0), B the reverse Bessel polynomial, s bilinear in z.

w0 puts the point at which the response is down by 3 dB at the corner fc; a high-pass has s inverted
(Thomson, Delay networks having maximally flat frequency characteristics, Proc. IEE 96, 1949).
"""

from proofmass.blocks.arithmetic.prototypes import LARGEST_ORDER, bessel
from proofmass.blocks.arithmetic.sections import Sections, designed, output, update, warped
from proofmass.blocks.declaration.declare import Block, Input, param


class Bessel(Block):
    """Digital low-pass or high-pass with the flattest delay: steps pass without ringing."""

    order: int = param("1", "Number of poles.", default=4, at_least=1, at_most=LARGEST_ORDER)
    corner_frequency: float = param("Hz", "Frequency at which it is down by 3 dB.", default=100.0, above=0.0)
    high_pass: bool = param("", "Whether it passes what is above the corner.", default=False)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to filter.")


@Bessel.constants
def constants(p: Bessel, period: float) -> Sections:
    return designed(bessel(p.order), p.order, p.high_pass, warped(p.corner_frequency, period))


Bessel.output("{unit}")(output)
Bessel.update(update)
