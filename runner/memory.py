"""Everything that moves while a graph runs, as one value: what engines start from and checkpoints hold."""

import copy
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from proofmass.graphs.schedule import Node
from proofmass.runner.plan import Plan

Rows = Sequence[Any]  # an array for each probe, with one row per recorded tick


@dataclass
class Memory:
    """State of every block, buffers, and what each wire holds, at the start of `tick`."""

    tick: int
    states: dict[str, Any]
    buffers: dict[Node, list[float]]
    wires: dict[Node, Any]

    def copy(self) -> "Memory":
        """A copy that moves on its own."""
        return Memory(self.tick, dict(self.states), copy.deepcopy(self.buffers), copy.deepcopy(self.wires))


class Engine(Protocol):
    """What runs a plan; it starts at tick 0 or at a given memory and owns what moves."""

    name: str

    def advance(self, last: int, rows: Rows) -> None:
        """Run up to, not including, the tick `last`; `rows` has an array for the rows of each probe, in their order."""
        ...

    def memory(self) -> Memory:
        """What moves, as it stands."""
        ...

    def snapshot(self) -> Callable[[], Memory]:
        """What moves, kept as it is now, and made a `Memory` when it is asked for."""
        ...

    def finite(self) -> bool:
        """Whether every number that moves is finite."""
        ...


def start(plan: Plan) -> Memory:
    """The memory at tick 0."""
    wires: dict[Node, Any] = {}
    for name, block in plan.blocks.items():
        for port, declared in block.outputs.items():
            shape = block.shape_of(declared)
            zero = declared.dtype(0)
            wires[name, port] = [zero] * shape[0] if shape else zero
    return Memory(0, dict(plan.starts), {key: list(values) for key, values in plan.buffers.items()}, wires)
