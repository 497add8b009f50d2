"""Difference of two signals: output = first - second."""

from proofmass.blocks.declaration.declare import Block, Input, param


class Difference(Block):
    """Difference of two signals of one unit: setpoint minus measurement."""

    unit: str = param("", "Unit of inputs and output.", default="1")

    first = Input("{unit}", "Signal to subtract from.")
    second = Input("{unit}", "Signal to subtract.")


@Difference.output("{unit}")
def output(p: Difference, first: float, second: float) -> float:
    """The first less the second."""
    return first - second
