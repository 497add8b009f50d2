"""Tangent of a signal: output = scale tan(input). It is infinite at an odd quarter of a turn."""

from proofmass.blocks.arithmetic.elementary import tangent
from proofmass.blocks.declaration.declare import Block, Input, param


class TangentFunction(Block):
    """Tangent of an angle: a slope, the projection of a tilt. ArcTangent2 is its inverse."""

    scale: float = param("{unit}", "Output where the tangent is 1.", default=1.0)
    unit: str = param("", "Unit of the output.", default="1")

    input = Input("rad", "The angle.")


@TangentFunction.output("{unit}")
def output(p: TangentFunction, input: float) -> float:
    """The tangent of the angle."""
    return p.scale * tangent(input)
