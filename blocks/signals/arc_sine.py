"""Arcsine of a signal: output = arcsin(input / reference), a quarter turn beyond the reference."""

from proofmass.blocks.arithmetic.elementary import arcsine
from proofmass.blocks.arithmetic.rounding import clip
from proofmass.blocks.declaration.declare import Block, Input, param


class ArcSine(Block):
    """Angle from its sine: the tilt by an accelerometer, the phase of a fringe about quadrature."""

    reference: float = param("{unit}", "Input of a quarter turn.", default=1.0, above=0.0)
    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "The sine times the reference.")


@ArcSine.output("rad")
def output(p: ArcSine, input: float) -> float:
    """The angle, from -pi/2 to pi/2."""
    return arcsine(clip(input / p.reference, -1.0, 1.0))


@ArcSine.corner
def above_lowest(p: ArcSine, input: float) -> float:
    return input + p.reference


@ArcSine.corner
def below_highest(p: ArcSine, input: float) -> float:
    return p.reference - input
