"""Logic buffer: output = input, without delay: one bit to all readers in a part of a graph."""

from proofmass.blocks.declaration.declare import Block, Input


class LogicBuffer(Block):
    """A bit passed on: the entry into a part of a graph that needs it in several places."""

    input = Input("1", "Bit from outside.", dtype=bool)


@LogicBuffer.output("1")
def output(p: LogicBuffer, input: bool) -> bool:
    """The input."""
    return input
