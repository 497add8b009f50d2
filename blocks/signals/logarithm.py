"""Logarithm of a signal: output = scale ln(u / reference) / ln(base), u = input, but at least `smallest`.

With base 10 and a scale of 20 an amplitude comes out in decibels of the reference.
"""

from proofmass.blocks.arithmetic.elementary import logarithm
from proofmass.blocks.declaration.declare import Block, Input, param


class Logarithm(Block):
    """Logarithm of a signal above zero: decibels, a logarithmic amplifier, a temperature from a thermistor."""

    base: float = param("1", "Base of the logarithm; e by default.", default=2.718281828459045, above=1.0)
    scale: float = param("{output_unit}", "Output where the input is base times the reference.", default=1.0)
    reference: float = param("{input_unit}", "Input at which the output is zero.", default=1.0, above=0.0)
    smallest: float = param(
        "{input_unit}", "Value that smaller and negative inputs count as.", default=1e-12, above=0.0
    )
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "Number to take the logarithm of.")


@Logarithm.output("{output_unit}")
def output(p: Logarithm, input: float) -> float:
    """The logarithm."""
    above = input if input > p.smallest else p.smallest
    return p.scale * (logarithm(above / p.reference) / logarithm(p.base))


@Logarithm.corner
def above_smallest(p: Logarithm, input: float) -> float:
    return input - p.smallest
