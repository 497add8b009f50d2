"""XOR gate: output = first other than second."""

from proofmass.blocks.declaration.declare import Block, Input


class XorGate(Block):
    """True where the two inputs differ: sum modulo 2, controlled inverter."""

    first = Input("1", "First input.", dtype=bool)
    second = Input("1", "Second input.", dtype=bool)


@XorGate.output("1")
def output(p: XorGate, first: bool, second: bool) -> bool:
    """True if the inputs differ."""
    return first != second
