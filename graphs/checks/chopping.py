"""Choppers whose demodulator reads what was sampled before the switch: notes.

A demodulator takes the sign of its modulator off what it reads in the same tick. Where the signal
passes a state on its way, as the pole of an amplifier, the first tick after a switch still has what
the last sign made of it. So one tick of each half period counts with the wrong sign, and the gain
is at most 1 - 2 / half_period.
"""

from collections.abc import Iterator

from proofmass.blocks import ChopperModulator
from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.digraph import reached
from proofmass.graphs.model.flatten import FlatGraph
from proofmass.graphs.model.graph import Endpoint, split


def chopping_notes(graph: FlatGraph) -> Iterator[Problem]:
    """Yield a note for each demodulator that reads its signal a tick late."""
    chopped = {name: block for name, block in graph.blocks.items() if isinstance(block, ChopperModulator)}
    if len(chopped) < 2:
        return
    drivers = {split(wire.target): split(wire.source) for wire in graph.wires}
    at_once, later = _reads(graph, drivers, at_once=True), _reads(graph, drivers, at_once=False)
    outputs = {(name, "output") for name in chopped}
    modulators: dict[str, set[str]] = {}  # of each demodulator
    for name in chopped:
        ways = {node: sources for node, sources in later.items() if node not in outputs or node[0] == name}
        before = {node[0] for node in reached(ways, [(name, "output")]) if node in outputs} - {name}
        modulators[name] = {other for other in before if chopped[other].half_period == chopped[name].half_period}
    demodulators = _demodulators(modulators)
    for name in sorted(demodulators):
        now = reached(at_once, [(name, "output")])
        late = sorted(other for other in modulators[name] - demodulators if (other, "output") not in now)
        if late:
            yield _late(graph, name, late[0], chopped[name].half_period)


def _reads(graph: FlatGraph, drivers: dict[Endpoint, Endpoint], *, at_once: bool) -> dict[Endpoint, list[Endpoint]]:
    """Return the outputs that each output reads, in the same tick or at any time."""
    return {
        (name, port): [
            drivers[name, entry]
            for entry in (type(block).feedthrough(port) if at_once else type(block).inputs)
            if (name, entry) in drivers
        ]
        for name, block in graph.blocks.items()
        for port in type(block).outputs
    }


def _demodulators(modulators: dict[str, set[str]]) -> set[str]:
    """Return the choppers that read one that is no demodulator: every other one of a chain."""
    known: dict[str, bool] = {}

    def demodulates(name: str) -> bool:
        if name not in known:
            known[name] = False  # in a ring the one that is asked for first is the modulator
            known[name] = any(not demodulates(other) for other in sorted(modulators[name]))
        return known[name]

    return {name for name in sorted(modulators) if demodulates(name)}


def _late(graph: FlatGraph, name: str, modulator: str, half_period: int) -> Problem:
    return Problem(
        message=f"it reads what was sampled before the switch of {modulator}",
        key=f"blocks.{name}.input",
        got=f"one tick of each {half_period} has the wrong sign: a gain of at most {1.0 - 2.0 / half_period:.3g}",
        expected="a signal of the same tick",
        hint=f"in its place multiply by {modulator}.square after a UnitDelay, or raise half_period and the rate",
        note=True,
        path=("blocks", name.partition(".")[0]),
    ).at(*graph.root.place.find(("blocks", name.partition(".")[0])))
