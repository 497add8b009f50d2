"""Two copies of a graph that share their noise: what becomes of a small change at a wire of one of its loops.

Copy `a` is the graph. Copy `b` is the same, but what is read of the wire v of a loop is

    w = v_a + direct (v_b - v_a) + late (D (v_b - v_a)) + push

D is a delay of the wire's ticks, or a low-pass between continuous blocks. While `push` is zero both copies stay alike
to the bit, whatever the factors: carriers, limit cycles, drift and noise are in both, so that v_b - v_a is what becomes
of a push alone. All of it is made of blocks of the library and run by the compiled engine. Nothing is linearised.
"""

import dataclasses
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from proofmass.blocks import Difference, FixedQuantiser, FixedToNumber, FractionalDelay, Gain, LowPass, Sine, Sum
from proofmass.blocks.arithmetic.fixed_point import FixedValue
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import format_of, unit_of
from proofmass.graphs.model.flatten import FlatGraph
from proofmass.graphs.model.graph import Endpoint, Probe, Wire, split
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan, varied
from proofmass.runner.targets.native import CompiledLoop, CompiledPlan

LONGEST = 4096  # ticks of the wire that a delay may have
SEED = 3


class Change(NamedTuple):
    """What is changed at a wire."""

    direct: float = 1.0
    late: float = 0.0
    delay: float = 1.0  # ticks of the wire; between continuous blocks the corner frequency in Hz of a low-pass

    def __str__(self) -> str:
        """The factors that count."""
        return f"{self.direct:.6g}" if not self.late else f"{self.direct:g}, and {self.late:g} after {self.delay:.6g}"


class Push(NamedTuple):
    """A sine that is added to a wire; at 0 Hz it is constant."""

    amplitude: float = 0.0
    frequency: float = 1.0  # Hz


NO_PUSH = Push()


class TwinPlan(Plan):
    """A plan of both copies: a block draws the same numbers as its twin, those of the graph alone."""

    def stream(self, name: str) -> int:
        """Number of the random stream of a block."""
        return super().stream(name[2:])

    @cached_property
    def _ends(self) -> Counter[str]:
        paths = (name[2:].split(".") for name in self.blocks if name.startswith("a."))
        return Counter(".".join(path[-length:]) for path in paths for length in range(1, len(path) + 1))


class Twins:
    """Both copies of a graph, compiled once for changes at the wires of all of its loops."""

    def __init__(self, flat: FlatGraph, wires: Mapping[str, str], continuous: frozenset[str] = frozenset()) -> None:
        """Take a flat graph, an output for each loop, and which loops lie among continuous blocks."""
        self._names = {loop: f"w{number}" for number, loop in enumerate(wires)}
        kinds = {loop: LowPass if loop in continuous else FractionalDelay for loop in wires}
        self.plan = _doubled(flat, {self._names[loop]: (source, kinds[loop]) for loop, source in wires.items()})
        self._compiled = CompiledPlan(self.plan)
        self._calm = dict[int, Memory]()

    def calm(self, tick: int) -> Memory:
        """Return the memory at a tick of a run without a push."""
        before = max((known for known in self._calm if known <= tick), default=None)
        if before != tick:
            memory = None if before is None else self._calm[before].copy()
            engine = CompiledLoop(self.plan, SEED, memory=memory, compiled=self._compiled)
            self._advance(engine, tick)
            self._calm[tick] = engine.memory()
        return self._calm[tick].copy()

    def apart(
        self, memory: Memory, loop: str, ticks: int, change: Change, push: Push = NO_PUSH
    ) -> tuple[Memory, np.ndarray, np.ndarray]:
        """Run on with a change at the wire of a loop; return the memory, and rows of v_b - v_a and of v_a.

        Raises `ArithmeticError` where a number is no longer finite.
        """
        engine = CompiledLoop(self._with(loop, change, push), SEED, memory=memory, compiled=self._compiled)
        rows = self._advance(engine, memory.tick + ticks)
        name = self._names[loop]
        return engine.memory(), rows[f"{name}.apart.output"], rows[f"{name}.own.output"]

    def _with(self, loop: str, change: Change, push: Push) -> Plan:
        name, blocks = self._names[loop], self.plan.blocks
        corner = isinstance(blocks[f"{name}.delay"], LowPass)
        numbers = {
            "direct": {"gain": change.direct},
            "late": {"gain": change.late},
            "delay": {"corner_frequency" if corner else "delay": change.delay},
            "push": push._asdict(),
        }
        parts = {f"{name}.{part}": new for part, new in numbers.items()}
        return varied(self.plan, {part: dataclasses.replace(blocks[part], **new) for part, new in parts.items()})

    def _advance(self, engine: CompiledLoop, last: int) -> dict[str, Any]:
        rows = [np.empty(probe.rows(engine.tick, last)) for probe in self.plan.probes]
        if not engine.advance(last, rows):
            raise ArithmeticError("a number is no longer finite")
        return {probe.signal: values for probe, values in zip(self.plan.probes, rows, strict=True)}


def _doubled(flat: FlatGraph, wires: Mapping[str, tuple[str, type[Block]]]) -> TwinPlan:
    """Return the plan of both copies, with the wires' blocks."""
    read = {source: f"{name}.changed.output" for name, (source, _) in wires.items()}
    blocks = {f"{copy}.{name}": block for copy in "ab" for name, block in flat.blocks.items()}
    rates = {f"{copy}.{name}": rate for copy in "ab" for name, rate in flat.rates.items()}
    offsets = {f"{copy}.{name}": offset for copy in "ab" for name, offset in flat.offsets.items()}
    joined = [Wire(f"a.{source}", f"a.{target}") for source, target in flat.wires]
    joined += [Wire(read.get(source, f"b.{source}"), f"b.{target}") for source, target in flat.wires]
    for name, (source, kind) in wires.items():
        node = split(source)
        added = {f"{name}.{part}": block for part, block in _at_wire(flat.blocks[node[0]], node, kind).items()}
        blocks |= added
        joined += _joined(name, source, f"{name}.sum" in added)
        rates |= dict.fromkeys(added, flat.rates[node[0]]) if node[0] in flat.rates else {}
        offsets |= dict.fromkeys(added, flat.offsets[node[0]]) if node[0] in flat.offsets else {}
    probes = tuple(Probe(f"{name}.{part}.output") for name in wires for part in ("apart", "own"))
    whole = flat.as_graph().bare(
        blocks=blocks, rates=rates, offsets=offsets, wires=tuple(joined), probes=probes, exports={}
    )
    planned = plan(whole)
    return TwinPlan(**{field.name: getattr(planned, field.name) for field in dataclasses.fields(planned)})


def _at_wire(block: Block, node: Endpoint, kind: type[Block]) -> dict[str, Block]:
    """Return the blocks that change a wire; a fixed-point one is a number between them."""
    port = type(block).outputs[node[1]]
    unit = unit_of(block, port)
    units = {"input_unit": unit, "output_unit": unit}
    late = LowPass(gain=2.0, **units) if kind is LowPass else FractionalDelay(delay=1.0, longest=LONGEST, unit=unit)
    blocks: dict[str, Block] = {
        "own": Gain(**units),
        "other": Gain(**units),
        "apart": Difference(unit=unit),
        "direct": Gain(**units),
        "delay": late,
        "late": Gain(gain=0.0, **units),
        "push": Sine(amplitude=0.0, frequency=1.0, phase=1.0, unit=unit),
        "changed": Sum(unit=unit),
    }
    if port.dtype is FixedValue:
        form = format_of(block, node[1])
        number = FixedToNumber(input_format=form, unit=unit)
        word = FixedQuantiser(output_format=form, unit=unit)
        blocks |= {"own": number, "other": number, "sum": blocks["changed"], "changed": word}
    return blocks


def _joined(name: str, source: str, fixed: bool) -> Iterator[Wire]:
    """Yield the wires of a wire's blocks."""
    yield Wire(f"a.{source}", f"{name}.own.input")
    yield Wire(f"b.{source}", f"{name}.other.input")
    total = "sum" if fixed else "changed"
    ends = {
        "apart.first": "other", "apart.second": "own", "direct.input": "apart", "delay.input": "apart",
        "late.input": "delay", f"{total}.first": "own", f"{total}.second": "direct", f"{total}.third": "late",
        f"{total}.fourth": "push",
    }  # fmt: skip
    if fixed:
        ends["changed.input"] = total
    yield from (Wire(f"{name}.{start}.output", f"{name}.{end}") for end, start in ends.items())
