"""Absolute value: output = |input|."""

from proofmass.blocks.declaration.declare import Block, Input, param


class Absolute(Block):
    """Magnitude of a signal: an ideal full-wave rectifier."""

    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to rectify.")


@Absolute.output("{unit}")
def output(p: Absolute, input: float) -> float:
    """The input without its sign."""
    return abs(input)


@Absolute.corner
def above_zero(p: Absolute, input: float) -> float:
    return input
