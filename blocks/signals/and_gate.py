"""AND gate: output = first and second and third and fourth."""

from proofmass.blocks.declaration.declare import Block, Input


class AndGate(Block):
    """True where all inputs are; two to four inputs."""

    first = Input("1", "First input.", dtype=bool)
    second = Input("1", "Second input.", dtype=bool)
    third = Input("1", "Third input.", dtype=bool, default=True)
    fourth = Input("1", "Fourth input.", dtype=bool, default=True)


@AndGate.output("1")
def output(p: AndGate, first: bool, second: bool, third: bool, fourth: bool) -> bool:
    """True if all inputs are true."""
    return first and second and third and fourth
