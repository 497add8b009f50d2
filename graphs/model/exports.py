"""What a graph exports, seen from outside: which name an inner port bears, and exports that are wrong."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

from proofmass.blocks.declaration.declare import Block, Port
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.flatten import FlatPlace, Origin, flatten, inside, parts
from proofmass.graphs.model.graph import Graph, split
from proofmass.graphs.model.names import Missing, find_any


def exported(graph: Graph) -> dict[str, tuple[Block, Port | Parameter]]:
    """Block and port or parameter behind each export that is right."""
    flat = flatten(graph)
    found = {name: find_any(flat, signal, graph) for name, signal in flat.exports.items()}
    return {name: what for name, what in found.items() if not isinstance(what, Missing)}


def exposed(root: Graph) -> dict[str, str]:
    """The outermost name of every signal of a block inside that is exported; without a dot where it is the root's."""
    names: dict[str, str] = {}
    for path, part in parts(root):
        for name, signal in part.exports.items():
            names.setdefault(path + inside(part, signal), path + name)
    return names


def open_inputs(root: Graph) -> list[Problem]:
    """Exported inputs without a value: the graph is a part, and cannot run alone."""
    flat = flatten(root)
    driven = {wire.target for wire in flat.wires}
    return [
        root.placed(
            Problem(
                message="the exported input is driven by nothing: the graph is a part of others and cannot run alone",
                key=f"exports.{name}",
                expected=f"a graph that uses this one and wires {name}",
                hint=f'use it as a block, graph = "FILE.toml", or wire a source to {root.exports[name]} here',
                path=("exports", name),
            )
        )
        for name, (_, what) in exported(root).items()
        if isinstance(what, Port) and _is_input(flat, flat.exports[name])
        if what.default is None and flat.exports[name] not in driven
    ]


def runs_alone(graph: Graph) -> bool:
    """Whether a graph without problems has a rate and drives its exported inputs itself."""
    flat = flatten(graph)
    rated = flat.rate is not None or all(name in flat.rates or type(b).continuous() for name, b in flat.blocks.items())
    return rated and not open_inputs(graph)


def bad_exports(root: Graph, flat: Graph) -> Iterator[Problem]:
    """Exports of what is not there, and of inputs that are driven inside or exported twice."""
    origins = _origins(flat)
    drivers: dict[str, list[str]] = {}
    for wire in flat.wires:
        drivers.setdefault(wire.target, []).append(origins[str(wire)].path if origins else "")
    for path, part in parts(root):
        names: dict[str, str] = {}
        for name, target in part.exports.items():
            signal = path + inside(part, target)
            found = find_any(flat, signal, root)
            message = hint = ""
            if isinstance(found, Missing):
                message, hint = found.message, found.hint
            elif _is_input(flat, signal) and any(driver.startswith(path) for driver in drivers.get(signal, ())):
                message = f"{target} is exported and driven inside"
                hint = "remove the export, or the wire"
            elif _is_input(flat, signal) and signal in names:
                message, hint = f"{target} is exported twice", f"remove {name}: it is exported as {names[signal]}"
            names.setdefault(signal, name)
            if message:
                key = f"{path}exports.{name}"
                yield part.placed(Problem(message=message, key=key, got=target, hint=hint, path=("exports", name)))


def unused_parts(root: Graph, flat: Graph) -> Iterator[Problem]:
    """Notes on subgraphs with exported outputs of which none is used."""
    used = set(_above(probe.signal for probe in root.probes))
    for path, part in parts(root):
        used |= {path + name for name in _above(wire.source for wire in part.wires)}
        used |= {path + name for name in _above(part.exports.values())}
    for path, part in parts(root):
        signals = {name: path + inside(part, signal) for name, signal in part.exports.items()}
        outputs = [name for name, signal in signals.items() if _is_output(flat, signal)]
        name = path[:-1]
        if name and outputs and name not in used:
            hint = f'wire one of {", ".join(outputs)}, or add "{name}.{outputs[0]}" to probes'
            message = "none of its exported outputs is used"
            yield Problem(message=message, key=f"blocks.{name}", hint=hint, note=True, path=("blocks", name))


def as_written(flat: Graph, problem: Problem) -> Problem:
    """A problem of a wire that names the ends as they are written, behind the path of their graph."""
    table, name = (*problem.path, "", "")[:2]
    if table != "wires" or name not in _origins(flat) or not problem.key.startswith("wires: "):
        return problem
    _, path, wire = _origins(flat)[name]
    ends = " -> ".join(path + end for end in wire.split(" -> "))
    return replace(problem, key=f"wires: {ends}")


def once(flat: Graph, problems: Iterable[Problem]) -> list[Problem]:
    """Problems of a part that is there several times, each said for the first of them alone."""
    kept: dict[str, Problem] = {}
    for problem in problems:
        table, name = (*problem.path, "", "")[:2]
        path = problem.key.partition("exports.")[0] if table == "exports" else ""
        if table == "blocks" and "." in name:
            path = f"{split(name)[0]}."
        elif table == "wires" and name in _origins(flat):
            path = _origins(flat)[name].path
        text = str(problem)
        kept.setdefault(text.replace(path, "") if path and problem.line else text + problem.key, problem)
    return list(kept.values())


def _origins(flat: Graph) -> Mapping[str, Origin]:
    return flat.place.origins if isinstance(flat.place, FlatPlace) else {}


def _above(signals: Iterable[str]) -> Iterator[str]:
    """Every path above the signals."""
    for signal in signals:
        while "." in signal:
            signal = split(signal)[0]
            yield signal


def _is_input(flat: Graph, signal: str) -> bool:
    name, port = split(signal)
    return name in flat.blocks and port in type(flat.blocks[name]).inputs


def _is_output(flat: Graph, signal: str) -> bool:
    name, port = split(signal)
    return name in flat.blocks and port in type(flat.blocks[name]).outputs
