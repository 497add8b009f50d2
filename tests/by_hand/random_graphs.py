"""Random graphs of the whole catalogue that are right: several rates, feedback, driven parameters, finite numbers."""

import contextlib
import random
from collections.abc import Mapping, Sequence
from pathlib import Path

from proofmass.blocks import (
    AnalogToDigital,
    DiscreteMassSpringDamper,
    FixedMassSpringDamper,
    FixedQuantiser,
    Gain,
    ImpulseResponseEstimator,
    Ramp,
    Saturation,
    ShiftRegister,
    UnitDelay,
)
from proofmass.blocks.arithmetic.fixed_point import FixedValue
from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import format_of, shape_of, unit_of
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.graph import Place
from proofmass.runner.contract.around import SIZES
from proofmass.runner.contract.drawn import random_block
from tests.by_hand.parts import cut

RATES = ("9600 Hz", "4800 Hz", "3200 Hz", "6400 Hz", "9600/7 Hz")  # ratios 2, 3, 3/2, 3/4, 7, 7/2, 14/3 ...
RESONATORS = (DiscreteMassSpringDamper, FixedMassSpringDamper)  # stable from some 16 kHz on
# Not those with events: where a step ends at one, plain Python takes seconds for a graph.
KINDS = [kind for kind in all_blocks().values() if not kind.events and kind not in RESONATORS]
ALL_KINDS = list(all_blocks().values())


def random_graphs(
    seeds: Sequence[int], folder: Path, largest: int = 8, kinds: Sequence[type[Block]] = KINDS
) -> list[Graph]:
    """A graph per seed, of 3 to `largest` blocks and those that they need.

    The kinds are dealt from shuffled decks, so that none is rare.
    """
    dice = random.Random(seeds[0])
    deck: list[type[Block]] = []
    graphs = []
    for seed in seeds:
        if len(deck) < largest:
            deck += dice.sample(kinds, len(kinds))
        count = dice.randint(3, largest)
        graphs.append(_Dealt(random.Random(seed), folder).graph(str(seed), deck[:count]))
        del deck[:count]
    return graphs


class _Dealt:
    """One graph as it grows: `blocks` are there, with all their wires; those of `dealt` come one after the other."""

    def __init__(self, dice: random.Random, folder: Path) -> None:
        self.dice, self.folder = dice, folder
        self.blocks: dict[str, Block] = {}
        self.wires: list[str] = []
        self.dealt: dict[str, Block] = {}

    def graph(self, name: str, kinds: Sequence[type[Block]]) -> Graph:
        dice = self.dice
        self.dealt = {self.new_name(n): self.drawn(kind) for n, kind in enumerate(kinds)}
        for block_name, block in self.dealt.items():
            for port in type(block).inputs.values():
                if port.default is None or dice.random() < 0.5:
                    self.wires.append(f"{self.source(block, port.name)} -> {block_name}.{port.name}")
            for parameter in type(block).parameters.values():
                if type(block).drivable(parameter.name) and dice.random() < 0.15:
                    value = getattr(block, parameter.name)
                    driver = self.add(Ramp(offset=value, slope=value, unit=unit_of(block, parameter)))
                    self.wires.append(f"{driver}.output -> {block_name}.{parameter.name}")
            self.blocks[block_name] = block
        rates = dice.sample(RATES, dice.randint(2, 3))
        graph = Graph(
            name=name,
            rate=rates[0],
            blocks=self.blocks,
            rates={n: dice.choice(rates) for n, b in self.blocks.items() if not type(b).continuous()},
            wires=self.wires,
            probes=[f"{n}.{port}" for n, block in self.blocks.items() for port in type(block).outputs],
            seed=dice.randrange(2**62),
            place=Place(folder=str(self.folder)),
        )
        for number in range(dice.choice((0, 0, 1, 2))):
            graph = cut(graph, dice, number)
        return graph

    def drawn(self, kind: type[Block]) -> Block:
        """A block with random parameters whose constants fit their formats."""
        while True:
            block = random_block(kind, self.dice, self.folder)
            constants = kind.functions.get("constants")
            with contextlib.suppress(OverflowError, ValueError):
                if constants is not None:
                    constants.function(block, 1e-3)
                return block

    def new_name(self, number: int) -> str:
        """Names whose alphabetical order is not that of the wiring."""
        return f"{self.dice.choice('abcdefgh')}_{number}"

    def add(self, block: Block) -> str:
        name = self.new_name(len(self.dealt) + len(self.blocks))
        self.blocks[name] = block
        return name

    def source(self, block: Block, port: str) -> str:
        """A signal for the input of a block."""
        declared = type(block).inputs[port]
        unit = unit_of(block, declared)
        if declared.dtype is FixedValue:
            quantiser = FixedQuantiser(output_format=format_of(block, port), unit=unit)
            return self.added(quantiser, self.signal(float, unit), "output")
        if declared.shape:
            cells = self.add(ImpulseResponseEstimator(cells=shape_of(block, declared)[0], chips=3, unit=unit))
            self.wires += [
                f"{self.signal(bool, '1')} -> {cells}.bit",
                f"{self.signal(float, unit)} -> {cells}.response",
            ]
            return f"{cells}.impulse_response"
        return self.signal(declared.dtype, unit)

    def signal(self, dtype: type, unit: str) -> str:
        """A signal for an input: of a block that is there, or delayed and limited of one that is still to come."""
        if dtype is bool:
            there = _outputs(self.blocks, bool)
            return self.dice.choice(there)[0] if there else f"{self.add(ShiftRegister())}.bit"
        if dtype is int:
            codes = _outputs(self.blocks, int)
            if codes:
                return self.dice.choice(codes)[0]
            return self.added(AnalogToDigital(bits=8), self.signal(float, "V"), "code")
        if unit == "F":  # a bridge divides by its capacitances
            return f"{self.add(Ramp(offset=1e-12, slope=1e-13, unit=unit))}.output"
        there, later = _outputs(self.blocks, float), _outputs(self.dealt, float)
        if not there and not later:
            return f"{self.add(Ramp(slope=1.0, unit=unit))}.output"
        back = not there or (later and self.dice.random() < 0.3)
        signal, known = self.dice.choice(later if back else there)
        if back:
            delayed = self.added(UnitDelay(unit=known), signal, "output")
            limit = SIZES.get(known, 1.0)
            signal = self.added(Saturation(unit=known, lowest=-limit, highest=limit), delayed, "output")
        if known != unit or self.dice.random() < 0.3:
            factor = self.dice.uniform(-1.5, 1.5) * SIZES.get(unit, 1.0) / SIZES.get(known, 1.0)
            gain = Gain(gain=factor, input_unit=known, output_unit=unit)
            signal = self.added(gain, signal, "output")
        return signal

    def added(self, block: Block, signal: str, output: str) -> str:
        """The output of a new block with one input, which the signal feeds."""
        name = self.add(block)
        self.wires.append(f"{signal} -> {name}.{next(iter(type(block).inputs))}")
        return f"{name}.{output}"


def _outputs(blocks: Mapping[str, Block], dtype: type) -> list[tuple[str, str]]:
    """Scalar outputs of a type, each with its unit."""
    return [
        (f"{name}.{port.name}", unit_of(block, port))
        for name, block in blocks.items()
        for port in type(block).outputs.values()
        if port.dtype is dtype and not port.shape
    ]
