"""Exponential of a signal: output = scale e^(input / reference), at most e^354 times the scale."""

from proofmass.blocks.arithmetic.elementary import bounded_exponential
from proofmass.blocks.declaration.declare import Block, Input, param


class Exponential(Block):
    """Exponential law of a signal: a diode's current, a thermistor, decibels to amplitude."""

    scale: float = param("{output_unit}", "Output where the input is zero.", default=1.0)
    reference: float = param("{input_unit}", "Rise of the input for a growth by e.", default=1.0, above=0.0)
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "The exponent.")


@Exponential.output("{output_unit}")
def output(p: Exponential, input: float) -> float:
    """The exponential."""
    return p.scale * bounded_exponential(input / p.reference)
