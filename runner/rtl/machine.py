"""The digital part of a graph as one synchronous machine, as data: instances of modules, nets, clock enables.

One clock ticks at the rate that the rates of all its blocks divide. A block that is slower is enabled at its own ticks,
a net that is slower than one of its readers is kept in between. What blocks outside give are inputs; what they or
probes read are outputs.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from proofmass.graphs.schedule import Node
from proofmass.runner.rtl.modules import Module
from proofmass.runner.rtl.words import Port, Word


@dataclass(frozen=True)
class Net:
    """One number of an output of the graph: `signal` as "cell.coefficient" or "bank.sums[3]".

    It has a new value every `stride` clocks; where it is `kept`, the last one is seen at all others.
    """

    name: str
    signal: str
    word: Word
    stride: int = 1
    kept: bool = False


@dataclass(frozen=True)
class Instance:
    """A block of the graph: `path` is its name there, `stride` the clocks from one of its ticks to the next.

    `inputs` and `outputs` say by the name of the module's port which net it is, or which number.
    """

    name: str
    path: str
    module: Module
    stride: int
    inputs: Mapping[str, Net | int]
    outputs: Mapping[str, Net]


@dataclass(frozen=True)
class Machine:
    """The digital part of a graph. The text of a port is its signal in the graph.

    `order` has the outputs of the blocks, as (path, port), each behind those that it needs in the same tick.
    """

    name: str
    rate: Fraction  # of the clock
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    instances: tuple[Instance, ...]
    order: tuple[Node, ...]
    nets: Mapping[str, Net]  # by signal: what instances give, and the inputs

    @cached_property
    def modules(self) -> tuple[Module, ...]:
        """The modules, each once."""
        return tuple({each.module.name: each.module for each in self.instances}.values())

    @cached_property
    def strides(self) -> tuple[int, ...]:
        """Clocks from one enable to the next, in ascending order, where that is not every clock."""
        found = {each.stride for each in self.instances} | {net.stride for net in self.nets.values() if net.kept}
        return tuple(sorted(found - {1}))

    @cached_property
    def counters(self) -> tuple[tuple[int, int, int], ...]:
        """What makes the enable of each stride: (stride, the longest shorter one that divides it, last count)."""
        found = []
        for stride in self.strides:
            over = max(each for each in (1, *self.strides) if each < stride and stride % each == 0)
            found.append((stride, over, stride // over - 1))
        return tuple(found)

    @property
    def single(self) -> bool:
        """Whether the module of its one block is all of it."""
        return len(self.instances) == 1 and not self.strides
