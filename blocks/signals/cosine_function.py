"""Cosine of a signal: output = amplitude cos(input)."""

from proofmass.blocks.arithmetic.elementary import cosine
from proofmass.blocks.declaration.declare import Block, Input, param


class CosineFunction(Block):
    """Cosine of an angle: the response of an interferometer, a resolver. Sine and the NCO make oscillations of time."""

    amplitude: float = param("{unit}", "Output where the cosine is 1.", default=1.0)
    unit: str = param("", "Unit of the output.", default="1")

    input = Input("rad", "The angle.")


@CosineFunction.output("{unit}")
def output(p: CosineFunction, input: float) -> float:
    """The cosine of the angle."""
    return p.amplitude * cosine(input)
