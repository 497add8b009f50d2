"""Elliptic band-pass or band-stop: its prototype with s = (s^2 + w0^2) / (b s), or one over that.

w0^2 = t1 t2, b = t2 - t1, t = tan(pi f T) at both edges; 2n poles (Oppenheim and Schafer,
Discrete-Time Signal Processing, section 7.1).
"""

from collections.abc import Iterator

from proofmass.blocks.arithmetic.bands import banded
from proofmass.blocks.arithmetic.elliptic import elliptic
from proofmass.blocks.arithmetic.sections import Sections, output, update
from proofmass.blocks.declaration.declare import Input, param
from proofmass.blocks.parameter_sets.band_edges import BandEdges, ordered


class EllipticBand(BandEdges):
    """Digital band-pass or band-stop of steepest edges: ripples where it passes and stops."""

    low_frequency: float = param("Hz", "Frequency at which the ripple ends below the band.", default=80.0, above=0.0)
    high_frequency: float = param("Hz", "Frequency at which the ripple ends above the band.", default=120.0, above=0.0)
    ripple: float = param("1", "Ripple of the passband in decibels.", default=0.5, above=0.0, at_most=20.0)
    attenuation: float = param(
        "1", "Decibels by which what is stopped is down, at least.", default=40.0, above=0.0, at_most=200.0
    )

    input = Input("{unit}", "Signal to filter.")


@EllipticBand.requires
def requires(p: EllipticBand) -> Iterator[tuple[str, str]]:
    yield from ordered(p)
    if p.attenuation <= p.ripple:
        yield "attenuation", f"more than the ripple, {p.ripple:g}"


@EllipticBand.constants
def constants(p: EllipticBand, period: float) -> Sections:
    prototype = elliptic(p.order, p.ripple, p.attenuation)
    return banded(prototype, p.order, p.stop, p.low_frequency, p.high_frequency, period)


EllipticBand.output("{unit}")(output)
EllipticBand.update(update)
