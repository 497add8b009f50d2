"""Sum of up to four signals of one unit: output = (first + second) + (third + fourth)."""

from proofmass.blocks.declaration.declare import Block, Input, param

NOTHING = -0.0  # adding it changes no number, not even the sign of a zero, so that it costs nothing when compiled


class Sum(Block):
    """Sum of two to four signals; a Negation before an input, or a Difference, subtracts."""

    unit: str = param("", "Unit of inputs and output.", default="1")

    first = Input("{unit}", "First term.")
    second = Input("{unit}", "Second term.")
    third = Input("{unit}", "Third term.", default=NOTHING)
    fourth = Input("{unit}", "Fourth term.", default=NOTHING)


@Sum.output("{unit}")
def output(p: Sum, first: float, second: float, third: float, fourth: float) -> float:
    """The sum."""
    return (first + second) + (third + fourth)
