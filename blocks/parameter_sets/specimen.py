"""Specimen of a converter, by whose number the errors of its elements are drawn."""

from proofmass.blocks.declaration.declare import Block, param


class Specimen(Block):
    """Number of the specimen: equal numbers have equal errors."""

    device: float = param(
        "1",
        "Whole number of the specimen, whose errors are drawn; studies spread it.",
        default=1.0,
        at_least=0.0,
        at_most=1e15,
    )
