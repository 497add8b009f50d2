"""NOT gate: output = not input."""

from proofmass.blocks.declaration.declare import Block, Input


class NotGate(Block):
    """Inverter of a bit."""

    input = Input("1", "Bit to invert.", dtype=bool)


@NotGate.output("1")
def output(p: NotGate, input: bool) -> bool:
    """The opposite of the input."""
    return not input
