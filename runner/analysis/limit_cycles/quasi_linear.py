"""Graphs whose nonlinear blocks are replaced by gains: stated ones, or those for a sine of a stated amplitude."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, did_you_mean
from proofmass.blocks.declaration.units import convert
from proofmass.blocks.signals.gain import Gain
from proofmass.graphs.checks.schedule import block_rate
from proofmass.graphs.model.flatten import FlatGraph, flatten
from proofmass.graphs.model.graph import Graph, Wire, split
from proofmass.runner.analysis.limit_cycles.describing import Describing, describing_function
from proofmass.runner.plan.groups import analogue


def with_gains(graph: Graph, gains: Mapping[str, float | str], amplitudes: Mapping[str, float | str]) -> Graph:
    """Return the graph with blocks replaced by stated gains, or by describing functions at
    amplitudes of their input.

    Raises `ModelError` if a block has no number to multiply, or its describing function shifts the
    phase.
    """
    flat = flatten(graph)
    factors: dict[str, float] = {}
    for name, stated in gains.items():
        factors[name] = _number(flat, name, stated, _unit(flat, name, "{out}") + "/" + _unit(flat, name, "{in}"))
    for name, stated in amplitudes.items():
        amplitude = _number(flat, name, stated, _unit(flat, name, "{in}"))
        if not amplitude > 0.0:
            raise _refused(flat, name, "the amplitude must be above zero", str(stated))
        gain = complex(describing_of(flat, name)(amplitude))
        if abs(gain.imag) > 1e-6 * abs(gain):
            hint = "--limit-cycle finds the amplitude and the frequency with this phase shift"
            raise _refused(flat, name, "shifts the phase at this amplitude, so it is not a gain", f"{gain:.6g}", hint)
        factors[name] = gain.real
    return replaced(flat, factors)


def replaced(flat: FlatGraph, gains: Mapping[str, float]) -> Graph:
    """Return the graph without subgraphs, with blocks replaced by gains of the same units.

    What works at ticks goes on so, at its rate: a gain of its own would follow continuous signals
    at every instant.
    """
    blocks, wires = dict(flat.blocks), []
    for name, gain in gains.items():
        block, (entry, port) = flat.blocks[name], ends(flat, name)
        units = {
            "input_unit": unit_of(block, type(block).inputs[entry]),
            "output_unit": unit_of(block, type(block).outputs[port]),
        }
        blocks[name] = Gain(gain=gain, **units)
    for wire in flat.wires:
        (source, port), (target, entry) = split(wire.source), split(wire.target)
        if source in gains and (source, port) != (source, ends(flat, source)[1]):
            raise _refused(flat, source, f"has another output that is read: {wire.source}", "")
        if target in gains and entry != ends(flat, target)[0]:
            continue
        before = f"{source}.output" if source in gains else wire.source
        after = f"{target}.input" if target in gains else wire.target
        wires.append(Wire(before, after))
    probes = tuple(probe for probe in flat.probes if split(probe.signal)[0] not in gains)
    loops = {name: replace(loop, open_at=_renamed(flat, loop.open_at, gains)) for name, loop in flat.loops.items()}
    clocked = [name for name in gains if not type(flat.blocks[name]).continuous() and not analogue(flat, name)]
    rates = {**flat.rates, **{name: block_rate(flat, name) for name in clocked}}
    return flat.as_graph().bare(blocks=blocks, wires=tuple(wires), probes=probes, loops=loops, rates=rates)


def describing_of(flat: FlatGraph, name: str) -> Describing:
    """Return N(A) of a block of a flat graph; raises `ModelError` if it has none."""
    entry, port = ends(flat, name)
    block = flat.blocks[name]
    for wire in flat.wires:
        target, driven = split(wire.target)
        if target == name and driven not in type(block).inputs:
            told = "is moved by a wire, so its describing function is not known"
            hint = f'set it under [blocks.{name}], or state a gain: --gain "{name}=0.7"'
            raise _refused(flat, name, told, f"{wire.source} -> {wire.target}", hint)
    period = 1.0 if type(block).continuous() else float(1 / block_rate(flat, name))
    try:
        return describing_function(block, entry, port, period)
    except ValueError as error:
        raise _refused(flat, name, str(error), type(block).__name__) from None


def ends(flat: FlatGraph, name: str) -> tuple[str, str]:
    """Return wired input and output, single numbers, between which a block counts as a gain."""
    kind = type(_block(flat, name))
    read = {split(wire.source)[1] for wire in flat.wires if split(wire.source)[0] == name}
    driven = [split(wire.target)[1] for wire in flat.wires if split(wire.target)[0] == name]
    entries = [entry for entry in driven if entry in kind.inputs and _is_number(kind.inputs[entry])]
    outputs = [port for port, made in kind.outputs.items() if _is_number(made) and port in read]
    if len(entries) != 1 or len(outputs) != 1:
        got = f"inputs {', '.join(entries) or 'none'}; outputs {', '.join(outputs) or 'none'}"
        raise _refused(flat, name, "is not a gain: that needs one wired input and one output that is read", got)
    return entries[0], outputs[0]


def _is_number(port: Any) -> bool:
    return port.dtype is float and not port.shape


def _unit(flat: FlatGraph, name: str, side: str) -> str:
    block, (entry, port) = _block(flat, name), ends(flat, name)
    unit = unit_of(block, type(block).inputs[entry] if side == "{in}" else type(block).outputs[port])
    return f"({unit})"


def _number(flat: FlatGraph, name: str, stated: float | str, unit: str) -> float:
    try:
        return float(stated)
    except ValueError:
        pass
    try:
        return convert(str(stated), unit)
    except Refusal as error:
        raise _refused(flat, name, str(error), str(stated), error.hint) from None


def _renamed(flat: FlatGraph, signal: str, gains: Mapping[str, float]) -> str:
    name, port = split(signal)
    return f"{name}.output" if name in gains and port == ends(flat, name)[1] else signal


def _block(flat: FlatGraph, name: str) -> Block:
    if name not in flat.blocks:
        hint = did_you_mean(name, flat.blocks, "the blocks")
        raise Problem(message="there is no such block", key=name, hint=hint).error
    return flat.blocks[name]


def _refused(flat: FlatGraph, name: str, message: str, got: str, hint: str = "") -> ModelError:
    problem = Problem(message=message, got=got, hint=hint, path=("blocks", name))
    return flat.placed(problem).error
