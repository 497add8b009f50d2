"""Maximum of two signals: output = first if first > second, else second."""

from proofmass.blocks.declaration.declare import Block, Input, param


class Maximum(Block):
    """The larger of two signals of one unit: a limit that is a signal. Chain two for three."""

    unit: str = param("", "Unit of inputs and output.", default="1")

    first = Input("{unit}", "First signal.")
    second = Input("{unit}", "Second signal.")


@Maximum.output("{unit}")
def output(p: Maximum, first: float, second: float) -> float:
    """The larger one."""
    return first if first > second else second


@Maximum.corner
def order(p: Maximum, first: float, second: float) -> float:
    return first - second
