"""Sine of a signal: output = amplitude sin(input)."""

from proofmass.blocks.arithmetic.elementary import sine
from proofmass.blocks.declaration.declare import Block, Input, param


class SineFunction(Block):
    """Sine of an angle: the response of an interferometer, a resolver. Sine and the NCO make oscillations of time."""

    amplitude: float = param("{unit}", "Output where the sine is 1.", default=1.0)
    unit: str = param("", "Unit of the output.", default="1")

    input = Input("rad", "The angle.")


@SineFunction.output("{unit}")
def output(p: SineFunction, input: float) -> float:
    """The sine of the angle."""
    return p.amplitude * sine(input)
