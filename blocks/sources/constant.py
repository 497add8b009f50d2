"""Constant source: output = value."""

from proofmass.blocks.declaration.declare import Block, param


class Constant(Block):
    """A value that does not change."""

    value: float = param("{unit}", "Value of the output.", default=0.0)
    unit: str = param("", "Unit of the output.", default="1")


@Constant.output("{unit}")
def output(p: Constant) -> float:
    """The value."""
    return p.value
