"""Arc tangent of two signals: angle = atan2(quadrature, in_phase), from -pi to pi."""

from proofmass.blocks.arithmetic.elementary import arctangent2
from proofmass.blocks.declaration.declare import Block, Input, param


class ArcTangent2(Block):
    """Phase of a pair in quadrature: the angle of a resolver, an I/Q demodulator, a sine and cosine interferometer."""

    unit: str = param("", "Unit of both inputs.", default="1")

    quadrature = Input("{unit}", "Sine part, y.")
    in_phase = Input("{unit}", "Cosine part, x.")


@ArcTangent2.output("rad")
def angle(p: ArcTangent2, quadrature: float, in_phase: float) -> float:
    """The angle."""
    return arctangent2(quadrature, in_phase)


@ArcTangent2.corner
def above_cut(p: ArcTangent2, quadrature: float) -> float:
    return quadrature
