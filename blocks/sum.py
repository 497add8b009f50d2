"""Weighted sum of up to four signals of one unit."""

from proofmass.blocks.declare import Block, Input, param


class Sum(Block):
    """Weighted sum; a weight of -1 subtracts. `third` and `fourth` may stay unconnected."""

    weight_first: float = param(1.0, "1", "Weight of `first`.")
    weight_second: float = param(1.0, "1", "Weight of `second`.")
    weight_third: float = param(1.0, "1", "Weight of `third`.")
    weight_fourth: float = param(1.0, "1", "Weight of `fourth`.")
    unit: str = param("1", "", "Unit of inputs and output.")

    first = Input("{unit}", "First term.")
    second = Input("{unit}", "Second term.")
    third = Input("{unit}", "Third term.", default=0.0)
    fourth = Input("{unit}", "Fourth term.", default=0.0)


@Sum.output("{unit}")
def output(p: Sum, first: float, second: float, third: float, fourth: float) -> float:
    """The weighted sum."""
    return p.weight_first * first + p.weight_second * second + p.weight_third * third + p.weight_fourth * fourth
