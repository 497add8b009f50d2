"""Square root: output = sign(input) sqrt(|input|) where it is signed, else sqrt(max(input, 0))."""

import math

from proofmass.blocks.declaration.declare import Block, Input, param


class SquareRoot(Block):
    """Linearises a quadratic response: of an electrostatic force, a detector of power."""

    signed: bool = param("", "Whether a negative input gives a negative root instead of 0.", default=False)
    unit: str = param("", "Unit of the output; that of the input is its square.", default="1")

    input = Input("({unit})^2", "Number to take the root of.")


@SquareRoot.output("{unit}")
def output(p: SquareRoot, input: float) -> float:
    """The root."""
    if input > 0.0:
        return math.sqrt(input)
    return -math.sqrt(-input) if p.signed and input < 0.0 else 0.0


@SquareRoot.corner
def above_zero(p: SquareRoot, input: float) -> float:
    return input
