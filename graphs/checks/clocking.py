"""Notes on blocks at another rate than their neighbours suggest, or a tick late."""

from collections import defaultdict
from collections.abc import Iterator
from fractions import Fraction

from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.behaviour import reads
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import size_of
from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.checks.names_used import as_written
from proofmass.graphs.checks.sampling import sampling_notes
from proofmass.graphs.model.flatten import FlatGraph, has_own_rate
from proofmass.graphs.model.graph import Endpoint, split
from proofmass.graphs.model.rates import write_rate


def clocking_notes(flat: FlatGraph) -> Iterator[Problem]:
    """Notes on a flat graph whose wires are right, in the order of its blocks."""
    wiring = _Wiring(flat)
    for name, block in flat.blocks.items():
        if type(block).continuous():
            yield from _late(wiring, name, block)
        elif "update" in type(block).functions and not has_own_rate(flat, name):
            yield from _repeated(wiring, name)
            yield from _passed_over(wiring, name)


def notes_of_a_run(flat: FlatGraph) -> list[Problem]:
    """Notes on a correct graph with their places, for a run without a check."""
    return [flat.placed(as_written(flat, problem)) for problem in (*clocking_notes(flat), *sampling_notes(flat))]


class _Wiring:
    """The drivers and readers of each block, with their rates."""

    def __init__(self, flat: FlatGraph) -> None:
        self.flat = flat
        self.drivers: dict[str, dict[str, Endpoint]] = defaultdict(dict)  # by block and its input or parameter
        self.readers: dict[str, list[Endpoint]] = defaultdict(list)
        for wire in flat.wires:
            (name, entry), source = split(wire.target), split(wire.source)
            self.drivers[name][entry] = source
            self.readers[source[0]].append((name, entry))
        self.probed = {split(probe.signal)[0] for probe in flat.probes}
        self._held: dict[str, bool] = {}

    def rate(self, name: str) -> Fraction | None:
        """The rate of a discrete block; None of a continuous one."""
        return None if type(self.flat.blocks[name]).continuous() else self.flat.rates.get(name, self.flat.rate)

    def rate_of(self, node: Endpoint) -> Fraction | None:
        """Rate at which an output changes; None if it moves between ticks."""
        name, port = node
        block, rate = self.flat.blocks[name], self.rate(name)
        return rate and rate / size_of(block, type(block).outputs[port].every)

    def stands_still(self, name: str) -> bool:
        """Return whether a block has the same outputs in every tick."""
        kind = type(self.flat.blocks[name])
        behaviours = [*kind.functions.values(), *kind.output_functions.values()]
        meanings = {meaning for behaviour in behaviours for meaning in behaviour.meanings}
        told = {Meaning.TIME, Meaning.TICK, Meaning.DEVIATE} & meanings
        moved = {"update", "derivative"} & kind.functions.keys()
        return not (told or moved or kind.events or self.drivers[name])

    def held(self, name: str) -> bool:
        """Return whether the outputs of a block hold their values from tick to tick."""
        if name not in self._held:
            self._held[name] = True  # first guess: a loop of blocks without memory stays at rest
            self._held[name] = self._is_held(self.flat.blocks[name], name)
        return self._held[name]

    def _is_held(self, block: Block, name: str) -> bool:
        kind = type(block)
        if kind.continuous():
            return False
        ports = (*kind.inputs.values(), *kind.outputs.values())
        meanings = {meaning for behaviour in kind.output_functions.values() for meaning in behaviour.meanings}
        clocked = kind.state_class() is not None or kind.buffers or has_own_rate(self.flat, name)
        ticking = {Meaning.TICK, Meaning.DEVIATE} & meanings
        if clocked or ticking or any(port.dtype is not float or port.shape for port in ports):
            return True
        if Meaning.TIME in meanings and self.flat.integration.sources != "held":
            return False
        return all(self.held(source) for source, _ in self.drivers[name].values())


def _repeated(wiring: _Wiring, name: str) -> Iterator[Problem]:
    """Yield a note on a block with memory that reads slower wires alone.

    An integrator whose output faster blocks read may be meant so: its result depends on the time,
    not on its ticks.
    """
    own_rate = wiring.rate(name)
    sources = [node for node in wiring.drivers[name].values() if not wiring.stands_still(node[0])]
    rates = [wiring.rate_of(node) for node in sources]
    known = [rate for rate in rates if rate is not None]
    if own_rate is None or not rates or len(known) < len(rates) or max(known) >= own_rate:
        return
    fastest = max(known)
    readers = [wiring.rate(reader) for reader, _ in wiring.readers[name]]
    if _knows_its_period(wiring.flat.blocks[name]) and any(rate is None or rate > fastest for rate in readers):
        return
    read = " and ".join(".".join(node) for node, rate in zip(sources, rates, strict=True) if rate == fastest)
    yield _note(
        name,
        f"reads the same value {_times(own_rate / fastest)} times: it has no rate of its own",
        f"{write_rate(own_rate)}, and {read} at {write_rate(fastest)}",
        f'add rate = "{write_rate(fastest)}" to the block, or rate = "{write_rate(own_rate)}" where it is meant so',
    )


def _knows_its_period(block: Block) -> bool:
    """Return whether a block's change in a tick depends on its period."""
    made = type(block).functions.get("constants")
    return made is not None and reads(made.function, "period")


def _passed_over(wiring: _Wiring, name: str) -> Iterator[Problem]:
    """Yield a note on a block with memory between a wire and slower blocks that read it."""
    own_rate = wiring.rate(name)
    readers = list(dict.fromkeys(reader for reader, _ in wiring.readers[name]))
    rates = [wiring.rate(reader) for reader in readers]
    stated = [rate for rate in rates if rate is not None]
    if own_rate is None or not rates or len(stated) < len(rates) or max(stated) >= own_rate or name in wiring.probed:
        return
    inputs, shown = set(wiring.drivers[name].values()), write_rate(own_rate)
    for reader, rate in zip(readers, stated, strict=True):
        both = sorted(".".join(node) for node in inputs & set(wiring.drivers[reader].values()))
        if both:
            yield _note(
                name,
                f"only one in {_times(own_rate / rate)} of its values is read: it has no rate of its own",
                f"{shown}; {reader} reads {both[0]} at {write_rate(rate)}, directly and through {name}",
                f'add rate = "{write_rate(rate)}" to the block, or rate = "{shown}" where it is meant so',
            )
            return


def _late(wiring: _Wiring, name: str, block: Block) -> Iterator[Problem]:
    """Yield a note on a block that only events change and whose inputs change at ticks: it switches a tick late."""
    read = {argument for pair in type(block).events.values() for behaviour in pair for argument in behaviour.arguments}
    inputs = [node for entry, node in wiring.drivers[name].items() if entry in read]
    clocked = [reader for reader, _ in wiring.readers[name] if not type(wiring.flat.blocks[reader]).continuous()]
    if "derivative" in type(block).functions or not inputs or not all(wiring.held(node[0]) for node in inputs):
        return
    if clocked or name in wiring.probed:
        yield _note(
            name,
            "switches after the tick in which its input does: what reads it at ticks reads it a tick late",
            f"{' and '.join('.'.join(node) for node in inputs)}, held from tick to tick",
            "take a Comparator, which answers in its own tick; a source that moves between ticks needs "
            'sources = "continuous" under [integration]',
        )


def _note(name: str, message: str, got: str, hint: str) -> Problem:
    return Problem(message=message, got=got, hint=hint, note=True, path=("blocks", name))


def _times(ratio: Fraction) -> str:
    return f"{ratio.numerator:,}" if ratio.denominator == 1 else f"{float(ratio):.3g}"
