"""Constant source: output = value."""

from proofmass.blocks.declare import Block, param


class Constant(Block):
    """A value that does not change."""

    value: float = param(0.0, "{unit}", "Value of the output.")
    unit: str = param("1", "", "Unit of the output.")


@Constant.output("{unit}")
def output(p: Constant) -> float:
    """The value."""
    return p.value
