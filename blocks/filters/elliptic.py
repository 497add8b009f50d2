"""Elliptic filter: |H|^2 = 1 / (1 + e^2 cd(n u K1, k1)^2), W = cd(u K, k), W = tan(pi f T) / tan(pi fc T), or 1 / W.

e^2 = 10^(ripple / 10) - 1; k1^2 = e^2 / (10^(attenuation / 10) - 1), and k follows from the order
(Orfanidis, Lecture Notes on Elliptic Filter Design, 2006).
"""

from collections.abc import Iterator

from proofmass.blocks.arithmetic.elliptic import elliptic
from proofmass.blocks.arithmetic.prototypes import LARGEST_ORDER
from proofmass.blocks.arithmetic.sections import Sections, designed, output, update, warped
from proofmass.blocks.declaration.declare import Block, Input, param


class Elliptic(Block):
    """Digital low-pass or high-pass of steepest edge: ripples where it passes and stops."""

    order: int = param("1", "Number of poles.", default=4, at_least=1, at_most=LARGEST_ORDER)
    corner_frequency: float = param("Hz", "Frequency at which the ripple ends.", default=100.0, above=0.0)
    ripple: float = param("1", "Ripple of the passband in decibels.", default=0.5, above=0.0, at_most=20.0)
    attenuation: float = param(
        "1", "Decibels by which what is stopped is down, at least.", default=40.0, above=0.0, at_most=200.0
    )
    high_pass: bool = param("", "Whether it passes what is above the corner.", default=False)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to filter.")


@Elliptic.requires
def requires(p: Elliptic) -> Iterator[tuple[str, str]]:
    if p.attenuation <= p.ripple:
        yield "attenuation", f"more than the ripple, {p.ripple:g}"


@Elliptic.constants
def constants(p: Elliptic, period: float) -> Sections:
    return designed(
        elliptic(p.order, p.ripple, p.attenuation), p.order, p.high_pass, warped(p.corner_frequency, period)
    )


Elliptic.output("{unit}")(output)
Elliptic.update(update)
