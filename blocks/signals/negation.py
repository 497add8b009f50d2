"""Negation: output = -input."""

from proofmass.blocks.declaration.declare import Block, Input, param


class Negation(Block):
    """Change of sign: the minus of a feedback loop."""

    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to negate.")


@Negation.output("{unit}")
def output(p: Negation, input: float) -> float:
    """The input with the other sign."""
    return -input
