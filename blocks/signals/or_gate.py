"""OR gate: output = first or second or third or fourth."""

from proofmass.blocks.declaration.declare import Block, Input


class OrGate(Block):
    """True where one input is or several are; two to four inputs."""

    first = Input("1", "First input.", dtype=bool)
    second = Input("1", "Second input.", dtype=bool)
    third = Input("1", "Third input.", dtype=bool, default=False)
    fourth = Input("1", "Fourth input.", dtype=bool, default=False)


@OrGate.output("1")
def output(p: OrGate, first: bool, second: bool, third: bool, fourth: bool) -> bool:
    """True if at least one input is true."""
    return first or second or third or fourth
