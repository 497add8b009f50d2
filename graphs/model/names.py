"""Meaning of a name in a wire, a probe or an export, or a hint at what to write instead."""

from collections.abc import Collection
from typing import NamedTuple

from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.declare import Block, Port
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.problem import did_you_mean, nearest
from proofmass.graphs.model.flatten import FlatGraph
from proofmass.graphs.model.graph import Graph, split


class Missing(NamedTuple):
    """A name without a meaning: the reason, what to write instead, and the signal meant."""

    message: str
    hint: str
    meant: str = ""
    absent: bool = False  # a whole block is not there


def find_output(flat: FlatGraph, signal: str) -> tuple[Block, Port] | Missing:
    """Block and port of an output of a flat graph."""
    name, port = split(signal)
    block = flat.blocks.get(name)
    if block is None:
        return _no_block(flat.root, signal, "outputs")
    kind = type(block)
    if port in kind.outputs:
        return block, kind.outputs[port]
    if port in kind.inputs:
        return Missing(f"{signal} is an input, not an output", _list(f"outputs of {name}", kind.outputs))
    if port in kind.parameters:
        return Missing(f"{signal} is a parameter, not an output", _list(f"outputs of {name}", kind.outputs))
    return Missing(f"{signal} is not an output", did_you_mean(port, kind.outputs, f"outputs of {name}"))


def find_target(flat: FlatGraph, signal: str) -> tuple[Block, Port | Parameter] | Missing:
    """Block and input, or parameter that a wire may drive, of a flat graph."""
    name, port = split(signal)
    block = flat.blocks.get(name)
    if block is None:
        return _no_block(flat.root, signal, "inputs")
    kind = type(block)
    if port in kind.inputs:
        return block, kind.inputs[port]
    if port in kind.parameters and kind.drivable(port):
        return block, kind.parameters[port]
    if port in kind.parameters and kind.taken_in_the_loop(port):
        return Missing(f"{signal} cannot be driven", kind.parameters[port].not_driven)
    if port in kind.parameters:
        why = "of a fixed-point block" if kind.has_formats() else "that fixes a size, a start or a choice"
        return Missing(f"{signal} cannot be driven", f"it is a parameter {why}: set it under [blocks.{name}]")
    if port in kind.outputs:
        return Missing(f"{signal} is an output, not an input", _list(f"inputs of {name}", kind.inputs))
    names = [*kind.inputs, *(parameter for parameter in kind.parameters if kind.drivable(parameter))]
    hint = did_you_mean(port, names, f"inputs of {name}")
    return Missing(f"{signal} is neither an input nor a parameter", hint, f"{name}.{nearest(port, names)}")


def find_any(flat: FlatGraph, signal: str) -> tuple[Block, Port | Parameter] | Missing:
    """Block and port or parameter of a flat graph."""
    name, port = split(signal)
    block = flat.blocks.get(name)
    if block is None:
        return _no_block(flat.root, signal, "ports")
    kind = type(block)
    for known in (kind.inputs, kind.outputs, kind.parameters):
        if port in known:
            return block, known[port]
    names = [*kind.inputs, *kind.outputs, *kind.parameters]
    hint = did_you_mean(port, names, f"ports and parameters of {name}")
    return Missing(f"{signal} is neither a port nor a parameter", hint)


def is_value(root: Graph, path: str) -> bool:
    """Return whether a path names a value of the graph, or of a subgraph."""
    graph, name = root, path
    while name not in graph.values:
        head, _, name = name.partition(".")
        if not name or head not in graph.subgraphs:
            return False
        graph = graph.subgraphs[head]
    return True


def is_rate(flat: FlatGraph, signal: str) -> bool:
    """Return whether a path names the rate of a block that is not continuous."""
    name, entry = split(signal)
    return entry == "rate" and name in flat.blocks and not type(flat.blocks[name]).continuous()


def _no_block(root: Graph, signal: str, what: str) -> Missing:
    """Report the first part of a path that does not exist, and what exists instead."""
    if "." not in signal:
        near = nearest(signal, [*root.blocks, *root.subgraphs])
        hint = f"name a port of {near}: {near}.PORT" if near else 'write "block.output"'
        return Missing(f"{signal} is not a signal", hint)
    if is_value(root, signal):
        return Missing(
            f"{signal} is a value, not a signal", "wires and probes join outputs; a Constant puts a value on a wire"
        )
    path, rest, graph = "", signal, root
    while True:
        head, _, tail = rest.partition(".")
        if not tail or head not in graph.subgraphs:
            break
        path, rest, graph = f"{path}{head}.", tail, graph.subgraphs[head]
    if path and not tail:
        name = path[:-1]
        # what is set takes values of the part too
        names = [*graph.exports, *graph.values] if what == "ports" else list(graph.exports)
        hint = did_you_mean(head, names, f"what {name} exports" + (", and its values" if what == "ports" else ""))
        if head in graph.blocks or head in graph.subgraphs:
            hint = f"{head} is a block inside: name its port too, {signal}.PORT"
        near = nearest(head, names)
        words = {"inputs": "neither an input nor a parameter", "outputs": "not an output"}.get(what, "not exported")
        return Missing(f"{signal} is {words}", hint, f"{path}{near}" if near else "")
    name = split(rest)[0]
    if name not in graph.blocks and head in graph.blocks:
        return Missing(f"{path}{head} is a block without blocks inside", f"name a port of it: {path}{head}.PORT")
    names = [*graph.blocks, *graph.subgraphs]
    hint = did_you_mean(name, names, f"the blocks inside {path[:-1]}" if path else "the blocks")
    declare = f" Otherwise declare it: [blocks.{name}] and below it its kind"
    return Missing(f"there is no block {path}{name}", hint + (declare if not path else ""), absent=True)


def last_outputs(flat: FlatGraph) -> list[str]:
    """Return the outputs of blocks that read something, and of which nothing reads any."""
    reading, read = ({split(getattr(wire, side))[0] for wire in flat.wires} for side in ("target", "source"))
    last = [name for name in flat.blocks if name in reading - read]
    return [f"{name}.{port}" for name in last for port in type(flat.blocks[name]).outputs]


def sources_of(flat: FlatGraph, output: str) -> list[str]:
    """Return sources of numbers an output follows from, but noise; else those in subgraphs."""
    from proofmass.graphs.model.digraph import reached  # start-up time: few commands ask

    before: dict[str, list[str]] = {}
    for wire in flat.wires:
        before.setdefault(split(wire.target)[0], []).append(split(wire.source)[0])
    found = []
    for name in sorted(reached(before, [split(output)[0]])):
        kind = type(flat.blocks[name])
        functions = (*kind.functions.values(), *kind.output_functions.values())
        if not (kind.inputs or name in before or any(Meaning.DEVIATE in function.meanings for function in functions)):
            found += [f"{name}.{port}" for port, one in kind.outputs.items() if one.dtype is float and not one.shape]
    return [source for source in found if source.count(".") == 1] or found


def output_of_a_loop(flat: FlatGraph) -> str:
    """Return an output of the graph for hints: one fed back, or else the first wired."""
    from proofmass.graphs.model.digraph import loops  # start-up time: few graphs are refused

    ends = [(wire.source, split(wire.source)[0], split(wire.target)[0]) for wire in flat.wires]
    ways: dict[str, list[str]] = {}
    for _, block, target in ends:
        ways.setdefault(block, []).append(target)
    parts = loops(ways)
    fed_back = [output for output, *both in ends if any(part.issuperset(both) for part in parts)]
    return next(iter([*fed_back, *(output for output, *_ in ends)]), "block.output")


def _list(what: str, names: Collection[str]) -> str:
    return f"{what}: {', '.join(names) or 'none'}"
