"""Minimum of two signals: output = first if first < second, else second."""

from proofmass.blocks.declaration.declare import Block, Input, param


class Minimum(Block):
    """The smaller of two signals of one unit: a limit that is itself a signal. Chain two for three signals."""

    unit: str = param("", "Unit of inputs and output.", default="1")

    first = Input("{unit}", "First signal.")
    second = Input("{unit}", "Second signal.")


@Minimum.output("{unit}")
def output(p: Minimum, first: float, second: float) -> float:
    """The smaller one."""
    return first if first < second else second


@Minimum.corner
def order(p: Minimum, first: float, second: float) -> float:
    return first - second
