"""The digital part of a graph as one synchronous machine, as data: instances of modules, nets, clock enables.

The clock has the lowest rate that the rates of all blocks divide. A slower block is enabled at its
own ticks; a net slower than one of its readers is kept in between. Outputs of blocks outside are
inputs of the machine; whatever they or probes read are its outputs.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.rtl.machine.modules import Module
from proofmass.runner.rtl.machine.words import VerilogPort, Word


@dataclass(frozen=True)
class OutputNet:
    """One number of an output of the graph: `signal` as "cell.coefficient" or "bank.sums[3]".

    It has a new value every `stride` clocks; if it is `kept`, a register holds the last one between
    them. It comes `stage` ticks later than in the simulation.
    """

    name: str
    signal: str
    word: Word
    stride: int = 1
    kept: bool = False
    stage: int = 0


@dataclass(frozen=True)
class Instance:
    """A block of the graph: `path` is its name there, `stride` the clocks from one of its ticks to the next.

    `inputs` and `outputs` map the ports of the module to nets, or to numbers. The block takes its
    inputs `stage` ticks late.
    """

    name: str
    path: str
    module: Module
    stride: int
    inputs: Mapping[str, OutputNet | int]
    outputs: Mapping[str, OutputNet]
    stage: int = 0


@dataclass(frozen=True)
class Machine:
    """The digital part of a graph. The text of a port is its signal in the graph.

    `order` has the outputs of the blocks, as (path, port), each after those that it needs in the
    same tick.
    """

    name: str
    rate: Fraction  # of the clock
    inputs: tuple[VerilogPort, ...]
    outputs: tuple[VerilogPort, ...]
    instances: tuple[Instance, ...]
    order: tuple[Endpoint, ...]
    nets: Mapping[str, OutputNet]  # by signal: outputs of instances, and the inputs

    @cached_property
    def latency(self) -> int:
        """Ticks by which all outputs are late."""
        return max((self.nets[port.text].stage for port in self.outputs), default=0)

    @cached_property
    def delays(self) -> Mapping[OutputNet, int]:
        """Number of registers after each net that some readers take later than it comes."""
        delays: dict[OutputNet, int] = {}
        taken = [
            (net, each.stage) for each in self.instances for net in each.inputs.values() if isinstance(net, OutputNet)
        ]
        for net, stage in [*taken, *((self.nets[port.text], self.latency) for port in self.outputs)]:
            if stage > net.stage:
                delays[net] = max(delays.get(net, 0), stage - net.stage)
        return delays

    @cached_property
    def clocked(self) -> bool:
        """Return whether it has the ports clock, reset and enable."""
        return bool(self.strides or self.delays) or any(each.module.clocked for each in self.instances)

    @cached_property
    def modules(self) -> tuple[Module, ...]:
        """The modules, each once."""
        return tuple({each.module.name: each.module for each in self.instances}.values())

    @cached_property
    def strides(self) -> tuple[int, ...]:
        """Clocks from one enable to the next, in ascending order, without 1."""
        found = {each.stride for each in self.instances if each.module.clocked}
        found |= {net.stride for net in self.nets.values() if net.kept}
        return tuple(sorted(found - {1}))

    @cached_property
    def counters(self) -> tuple[tuple[int, int, int], ...]:
        """Counter for the enable of each stride: (stride, the longest shorter one that divides it, last count)."""
        counters = []
        for stride in self.strides:
            over = max(each for each in (1, *self.strides) if each < stride and stride % each == 0)
            counters.append((stride, over, stride // over - 1))
        return tuple(counters)

    @property
    def single(self) -> bool:
        """Return whether it is just the module of one block: no input is shared or a number, nothing is kept."""
        nets = list(self.instances[0].inputs.values())
        distinct = len(set(nets)) == len(nets) and all(isinstance(net, OutputNet) for net in nets)
        return len(self.instances) == 1 and not self.strides and distinct
