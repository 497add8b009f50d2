"""Everything that changes in a run, as one value: engines start from it, checkpoints store it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from proofmass.blocks.declaration.instance import shape_of
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.fixed.step_formats import held_as
from proofmass.runner.plan.keys import LargestOf, VectorOf
from proofmass.runner.plan.planned import Filled

Rows = Sequence[Any]  # an array for each probe, with one row per recorded tick


@dataclass
class Memory:
    """State of every block, buffers, values of wires, and overflows so far, at the start of `tick`.

    Lists change; the tuples among the buffers are recordings, which never change and are shared.
    """

    tick: int
    states: dict[str, Any]
    buffers: dict[VectorOf, Sequence[float]]
    wires: dict[Endpoint, Any]
    overflows: dict[str, int]  # ticks in which a cast saturated or wrapped, of digital blocks counted from tick 0 on

    def overflow_counts(self) -> dict[str, int]:
        """Ticks in which a value of a block saturated or wrapped; blocks that are not digital count in their state."""
        own = {name: x.overflows for name, x in self.states.items() if hasattr(x, "overflows")}
        return self.overflows | own

    def vector(self, node: VectorOf) -> Any:
        """The buffer of that name, or the value of the wire."""
        return self.buffers[node] if isinstance(node, LargestOf) or node in self.buffers else self.wires[node]

    def of_blocks(self) -> dict[Endpoint, Sequence[float]]:
        """The buffers that blocks declare."""
        return {node: held for node, held in self.buffers.items() if not isinstance(node, LargestOf)}

    def copy(self) -> "Memory":
        """A copy that changes independently."""
        buffers = {node: _copied(held) for node, held in self.buffers.items()}
        wires = {node: _copied(held) for node, held in self.wires.items()}
        return Memory(self.tick, dict(self.states), buffers, wires, dict(self.overflows))


class Engine(Protocol):
    """Runs a plan, from tick 0 or from a given memory; it owns all that changes."""

    @property
    def name(self) -> str:
        """The name that the table of engines has for it."""
        ...

    def advance(self, last: int, rows: Rows) -> bool:
        """Run up to, not including, the tick `last`; `rows` has an array for the rows of each
        probe, in their order.

        Return False, or a `TickError` if it is known, when a value of a wire in one of the ticks
        was not finite or did not fit its format.
        """
        ...

    def memory(self) -> Memory:
        """The present memory."""
        ...

    def snapshot(self) -> Callable[[], Memory]:
        """Keep the present values, and return a function that makes a `Memory` of them."""
        ...


def start(plan: Filled) -> Memory:
    """The memory at tick 0."""
    wires: dict[Endpoint, Any] = {}
    for name, block in plan.blocks.items():
        for port, declared in type(block).outputs.items():
            shape = shape_of(block, declared)
            zero = held_as(declared.dtype)(0)
            wires[name, port] = [zero] * shape[0] if shape else zero
    buffers: dict[VectorOf, Sequence[float]] = {
        node: held if node in plan.recorded else list(held) for node, held in plan.buffers.items()
    }
    return Memory(0, dict(plan.starts), buffers, wires, dict.fromkeys(plan.digital, 0))


def _copied(held: Any) -> Any:
    return held.copy() if isinstance(held, list) else held
