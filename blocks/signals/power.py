"""Power: output = scale (|input| / reference)^exponent, with the input's sign if `odd`."""

from proofmass.blocks.arithmetic.elementary import power
from proofmass.blocks.declaration.declare import Block, Input, param


class Power(Block):
    """Power law with any positive exponent: a square-law detector, a nonlinear spring."""

    exponent: float = param("1", "The exponent.", default=2.0, above=0.0, at_most=16.0)
    odd: bool = param("", "Whether a negative input gives a negative output.", default=False)
    reference: float = param("{input_unit}", "Input at which the output is `scale`.", default=1.0, above=0.0)
    scale: float = param("{output_unit}", "Output at the reference.", default=1.0)
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "The base.")


@Power.output("{output_unit}")
def output(p: Power, input: float) -> float:
    """The power."""
    if input == 0.0:
        return 0.0
    size = p.scale * power(abs(input) / p.reference, p.exponent)
    return -size if p.odd and input < 0.0 else size


@Power.corner
def above_zero(p: Power, input: float) -> float:
    return input
