"""Bessel filter of order n: H(s) = B(0) / B(s / w0), B the reverse Bessel polynomial, s bilinear in z.

w0 puts the point at which the response is down by 3 dB at the corner fc; a high-pass has s inverted (Thomson, Delay
networks having maximally flat frequency characteristics, Proc. IEE 96, 1949).
"""

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

# Radius and quality of four pole pairs for each order, of the polynomial's roots to 17 digits.
TABLE = (
    1.0, 1.0, 1.0, 1.0,
    1.0, 1.0, 1.0, 1.0,
    1.272019649514069, 0.5773502691896257, 1.0, 1.0,
    1.0, 1.0, 1.0, 1.0,
    1.4476171331469874, 0.6910466258250713, 1.3226757999104448, 1.0,
    1.0, 1.0, 1.0, 1.0,
    1.603357516216973, 0.8055382818416658, 1.4301715599939906, 0.5219345816689802,
    1.0, 1.0, 1.0, 1.0,
    1.7553777766370968, 0.9164773739482478, 1.5563471222969236, 0.5635356208514565,
    1.502316271447479, 1.0, 1.0, 1.0,
    1.9047076123027622, 1.023313953826724, 1.6891682676204605, 0.6111945468780026,
    1.6039191287737986, 0.51031782474877, 1.0, 1.0,
    2.0494909002691073, 1.126257541983041, 1.8224174788579959, 0.6608213892970801,
    1.7163560448708648, 0.5323556978995465, 1.6843681792731802, 1.0,
    2.188726230527439, 1.2256694254081706, 1.9531957590220648, 0.710852074441698,
    1.8320926011985827, 0.5596091647957911, 1.778465911774649, 0.50599106939747,
)  # fmt: skip


class Bessel(Block):
    """Digital low-pass or high-pass with the flattest delay: steps pass without ringing."""

    order: int = param("1", "Number of poles.", default=4, at_least=1, at_most=LARGEST_ORDER)
    corner_frequency: float = param("Hz", "Where it is down by 3 dB.", default=100.0, above=0.0)
    high_pass: bool = param("", "Whether it passes what is above the corner.", default=False)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "What is filtered.")


@Bessel.constants
def constants(p: Bessel, period: float) -> Sections:
    i = 8 * (p.order - 1)
    poles = Poles(
        TABLE[i], TABLE[i + 1], TABLE[i + 2], TABLE[i + 3], TABLE[i + 4], TABLE[i + 5], TABLE[i + 6], TABLE[i + 7]
    )
    return designed(poles, p.order, p.high_pass, warped(p.corner_frequency, period), 1.0)


@Bessel.output("{unit}")
def output(c: Sections, x: Delays, input: float) -> float:
    """The filtered signal."""
    return filtered(c, x, input)


@Bessel.update
def update(c: Sections, x: Delays, input: float) -> Delays:
    return moved(c, x, input)
