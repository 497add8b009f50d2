"""A kind of block that no other test has registered functions on."""

from typing import Any

from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


def fresh_block() -> Any:
    class Fresh(Block):
        """A block to register functions on."""

        factor: float = param("1", "A factor.", default=1.0)
        voltage = Input("V", "In.")
        cells = Buffer("Cells.", float, (2,))

    return Fresh
