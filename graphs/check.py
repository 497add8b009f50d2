"""Everything that is wrong with the wiring of a graph, all at once."""

from collections.abc import Iterator
from fractions import Fraction

from proofmass.blocks.declare import Block, Port
from proofmass.blocks.parameter import Parameter
from proofmass.blocks.problem import ModelError, Problem, did_you_mean
from proofmass.blocks.units import same_dimension, same_unit, unit
from proofmass.graphs.graph import Graph, split
from proofmass.graphs.rates import LARGEST_RATIO, base_rate
from proofmass.graphs.schedule import schedule

LARGEST_GRAPH = 10_000  # blocks
LARGEST_WIRING = 100_000  # wires


def check(graph: Graph) -> list[Problem]:
    """All problems of a graph, each with its place; only notes are left when the graph can run."""
    problems = [*_size(graph), *_rates(graph)]
    wiring = list(_wires(graph)) + list(_unconnected(graph)) + list(_probes(graph))
    if not problems and not wiring:
        try:
            schedule(graph)
        except ModelError as error:
            wiring += error.problems
    notes = [] if problems or wiring else list(_unused(graph))
    return [graph.placed(problem) for problem in (*problems, *wiring, *notes)]


def checked(graph: Graph) -> Graph:
    """The graph itself when it can run; raises `ModelError` with every problem otherwise."""
    problems = [problem for problem in check(graph) if not problem.note]
    if problems:
        raise ModelError(problems)
    return graph


def _size(graph: Graph) -> Iterator[Problem]:
    if not graph.blocks:
        yield Problem(message="the graph has no blocks", key="blocks", hint="start from the one that `proofmass new` writes")
    for count, largest, key in (
        (len(graph.blocks), LARGEST_GRAPH, "blocks"),
        (len(tuple(graph.wires)), LARGEST_WIRING, "wires"),
    ):
        if count > largest:
            yield Problem(message="too many", key=key, got=str(count), expected=f"at most {largest}", path=(key,))


def _rates(graph: Graph) -> Iterator[Problem]:
    rates = []
    for name, block in graph.blocks.items():
        if block.continuous():
            if name in graph.rates:
                yield Problem(
                    message="a continuous block has no rate: it is integrated from each tick of the graph to the next",
                    key=f"blocks.{name}.rate",
                    hint="leave the rate out, or give it to the blocks that sample this one",
                    path=("blocks", name, "rate"),
                )
        elif name in graph.rates:
            rates.append(Fraction(graph.rates[name]))
        elif graph.rate is None:
            yield Problem(
                message="has no rate, and neither has the graph",
                key=f"blocks.{name}",
                hint='add rate = "50 kHz" at the top of the file, or to this block',
                path=("blocks", name),
            )
        else:
            rates.append(Fraction(graph.rate))
    if not rates and graph.rate is None:
        yield Problem(message="the graph has no rate", key="rate", hint='add rate = "50 kHz" at the top of the file')
    if rates and base_rate(rates) / min(rates) > LARGEST_RATIO:
        yield Problem(
            message="the rates have no common base rate within reach",
            key="rate",
            got=f"{float(base_rate(rates)):g} Hz is the least common multiple of {len(set(rates))} rates",
            expected=f"at most {LARGEST_RATIO:g} ticks of it in one tick of the slowest block",
            hint="make the rates ratios of small numbers",
            path=("rate",),
        )


def _wires(graph: Graph) -> Iterator[Problem]:
    driven_by: dict[str, str] = {}
    for wire in graph.wires:
        source, target = wire.source, wire.target  # type: ignore[union-attr]
        path = ("wires", f"{source} -> {target}")
        out, into = _output(graph, source), _target(graph, target)
        if isinstance(out, str):
            yield Problem(message=f"{source} is no output", key=f"wires: {wire}", hint=out, path=path)
        if isinstance(into, str):
            yield Problem(message=f"{target} is no input or parameter", key=f"wires: {wire}", hint=into, path=path)
        if target in driven_by:
            yield Problem(
                message=f"{target} is driven twice",
                key=f"wires: {wire}",
                got=f"{driven_by[target]} and {source}",
                expected="one wire",
                hint="remove one of the wires, or add the signals with a Sum",
                path=path,
            )
        driven_by[target] = source
        if not isinstance(out, str) and not isinstance(into, str):
            for message, got, expected, hint in _mismatches(*out, *into):
                yield Problem(message=message, key=f"wires: {wire}", got=got, expected=expected, hint=hint, path=path)


def _output(graph: Graph, signal: str) -> tuple[Block, Port] | str:
    """Block and port of an output, or a hint what to write instead."""
    name, port = split(signal)
    block = graph.blocks.get(name)
    if block is None:
        return did_you_mean(name, graph.blocks, "block")
    if port in block.inputs:
        return f"{port} is an input of {name}; its outputs: {', '.join(block.outputs) or 'none'}"
    return (block, block.outputs[port]) if port in block.outputs else did_you_mean(port, block.outputs, f"output of {name}")


def _target(graph: Graph, signal: str) -> tuple[Block, Port | Parameter] | str:
    name, port = split(signal)
    block = graph.blocks.get(name)
    if block is None:
        return did_you_mean(name, graph.blocks, "block")
    if port in block.inputs:
        return block, block.inputs[port]
    if port in block.parameters:
        if block.drivable(port):
            return block, block.parameters[port]
        why = "of a continuous block" if block.continuous() else "that fixes a size, a start or a choice"
        return f"{port} is a parameter {why}, which cannot be driven"
    if port in block.outputs:
        return f"{port} is an output of {name}; its inputs: {', '.join(block.inputs) or 'none'}"
    return did_you_mean(port, [*block.inputs, *block.parameters], f"input of {name}")


def _mismatches(source: Block, out: Port, target: Block, into: Port | Parameter) -> Iterator[tuple[str, str, str, str]]:
    got, expected = source.unit_of(out), target.unit_of(into)
    if not same_dimension(got, expected):
        same = f"{unit(got).in_base_units()} is not {unit(expected).in_base_units()}"
        yield "the units do not match", got, expected, f"{same}; a Gain with these units converts"
    elif not same_unit(got, expected):
        yield "the units differ by a factor", got, expected, "give both the same unit, or convert with a Gain"
    kind = into.dtype if isinstance(into, Port) else float
    if out.dtype is not kind:
        yield "the types do not match", out.dtype.__name__, kind.__name__, _same_type(source, kind)
    shape = target.shape_of(into) if isinstance(into, Port) else ()
    if source.shape_of(out) != shape:
        yield "the shapes do not match", str(source.shape_of(out)), str(shape), "a wire carries all entries of a port"


def _same_type(source: Block, kind: type) -> str:
    """A hint for a wire of the wrong type: nothing is converted in silence."""
    fitting = [name for name, port in source.outputs.items() if port.dtype is kind]
    if fitting:
        return f"its output {fitting[0]} has that type"
    return "an AnalogToDigital or DigitalToAnalog makes codes of numbers" if kind is int else "choose another output"


def _unconnected(graph: Graph) -> Iterator[Problem]:
    connected = {wire.target for wire in graph.wires}  # type: ignore[union-attr]
    for name, block in graph.blocks.items():
        for port, declared in block.inputs.items():
            if declared.default is None and f"{name}.{port}" not in connected:
                yield Problem(
                    message=f"the input {port} is not connected",
                    key=f"blocks.{name}",
                    expected=f"a wire that carries {block.unit_of(declared)}: {declared.doc}",
                    hint=f'add "… -> {name}.{port}" to wires' + _candidates(graph, block, declared),
                    path=("blocks", name),
                )


def _candidates(graph: Graph, block: Block, port: Port) -> str:
    """Outputs that would fit an input, for the hint."""
    fitting = [
        f"{name}.{out.name}"
        for name, other in graph.blocks.items()
        if other is not block
        for out in other.outputs.values()
        if not list(_mismatches(other, out, block, port))
    ]
    return f"; {', '.join(fitting[:3])} would fit" if fitting else ""


def _probes(graph: Graph) -> Iterator[Problem]:
    seen = set()
    for index, probe in enumerate(graph.probes):
        signal, path = probe.signal, ("probes", str(index))  # type: ignore[union-attr]
        found = _output(graph, signal)
        if isinstance(found, str):
            yield Problem(message=f"{signal} is no output", key="probes", hint=found, path=path)
        if signal in seen:
            yield Problem(message=f"{signal} is probed twice", key="probes", hint="remove one of the probes", path=path)
        seen.add(signal)


def _unused(graph: Graph) -> Iterator[Problem]:
    used = {split(wire.source) for wire in graph.wires} | {split(p.signal) for p in graph.probes}  # type: ignore[union-attr]
    for name, block in graph.blocks.items():
        if block.outputs and not any((name, port) in used for port in block.outputs):
            yield Problem(
                message="none of its outputs is used",
                key=f"blocks.{name}",
                hint=f'wire one of {", ".join(block.outputs)}, or add "{name}.{next(iter(block.outputs))}" to probes',
                note=True,
                path=("blocks", name),
            )
    if not graph.probes:
        yield Problem(message="no probes: a run records nothing", key="probes", hint="add probes = [\"block.output\"]", note=True)
