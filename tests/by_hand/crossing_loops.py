"""Two sums and two delays, each sum fed by both delays: loops that share wires, without one that all of them pass."""

from proofmass.blocks import Sum, UnitDelay
from proofmass.blocks.declaration.declare import Block

BLOCKS: dict[str, Block] = {"a": Sum(), "x": UnitDelay(), "b": Sum(), "y": UnitDelay()}
WIRES = [
    "a.output -> x.input",
    "b.output -> y.input",
    "x.output -> a.first",
    "y.output -> a.second",
    "x.output -> b.first",
    "y.output -> b.second",
]
