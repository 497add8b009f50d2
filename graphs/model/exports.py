"""What a graph exports, seen from outside: which name an inner port bears, and inputs that nothing drives."""

from proofmass.blocks.declaration.declare import Block, Port
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.flatten import FlatGraph, inside, parts
from proofmass.graphs.model.graph import Graph, split
from proofmass.graphs.model.names import Missing, find_any


def exported(flat: FlatGraph) -> dict[str, tuple[Block, Port | Parameter]]:
    """Block and port or parameter behind each export that is right."""
    found = {name: find_any(flat, signal) for name, signal in flat.exports.items()}
    return {name: what for name, what in found.items() if not isinstance(what, Missing)}


def exposed(root: Graph) -> dict[str, str]:
    """The outermost name of every signal of a block inside that is exported; without a dot where it is the root's."""
    names: dict[str, str] = {}
    for path, part in parts(root):
        for name, signal in part.exports.items():
            names.setdefault(path + inside(part, signal), path + name)
    return names


def open_inputs(flat: FlatGraph) -> list[Problem]:
    """Exported inputs without a value: the graph is a part, and cannot run alone."""
    driven = {wire.target for wire in flat.wires}
    return [
        flat.placed(
            Problem(
                message="the exported input is driven by nothing: the graph is a part of others and cannot run alone",
                key=f"exports.{name}",
                expected=f"a graph that uses this one and wires {name}",
                hint=f'use it as a block, graph = "FILE.toml", or wire a source to {flat.root.exports[name]} here',
                path=("exports", name),
            )
        )
        for name, (_, what) in exported(flat).items()
        if isinstance(what, Port) and is_input(flat, flat.exports[name])
        if what.default is None and flat.exports[name] not in driven
    ]


def runs_alone(flat: FlatGraph) -> bool:
    """Whether a graph without problems has a rate and drives its exported inputs itself."""
    rated = flat.rate is not None or all(name in flat.rates or type(b).continuous() for name, b in flat.blocks.items())
    return rated and not open_inputs(flat)


def is_input(flat: FlatGraph, signal: str) -> bool:
    name, port = split(signal)
    return name in flat.blocks and port in type(flat.blocks[name]).inputs
