"""Exports of a graph seen from outside: the names of inner ports, and inputs nothing drives."""

from proofmass.blocks.declaration.declare import Block, Port
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.problem import Problem, did_you_mean
from proofmass.graphs.model.flatten import FlatGraph, flatten, inside, parts
from proofmass.graphs.model.graph import Graph, split
from proofmass.graphs.model.names import Missing, find_any, is_rate, is_value

ONE_INSIDE = ' One inside: "block.parameter" = ...'


def exported(flat: FlatGraph) -> dict[str, tuple[Block, Port | Parameter]]:
    """Return block and port or parameter of each valid export."""
    found = {name: find_any(flat, signal) for name, signal in flat.exports.items()}
    return {name: what for name, what in found.items() if not isinstance(what, Missing)}


def settable(graph: Graph) -> list[str]:
    """Return names without a dot to which a graph takes numbers: its values, and exported parameters and rates."""
    flat = flatten(graph)
    parameters = [name for name, (_, what) in exported(flat).items() if not isinstance(what, Port)]
    others = (n for n, signal in flat.exports.items() if is_rate(flat, signal) or is_value(graph, graph.exports[n]))
    return [*dict.fromkeys([*graph.values, *parameters, *others])]


def not_settable(graph: Graph, name: str) -> str:
    """Return a hint for a name without a dot to which a graph takes no number."""
    if name in graph.blocks:
        own = next(iter(type(graph.blocks[name]).parameters), "PARAMETER")
        return f'{name} is a block: name a parameter of it, as "{name}.{own}"'
    if name in graph.subgraphs:
        return f'{name} is a subgraph: name a value or parameter of it, as "{name}.PARAMETER"'
    hint = did_you_mean(name, settable(graph), "its values and the parameters that it exports")
    return hint if hint.startswith("did you mean") else hint + ONE_INSIDE


def exposed(root: Graph) -> dict[str, str]:
    """Return the outermost name of every exported signal; without a dot if the root exports it."""
    names: dict[str, str] = {}
    for path, part in parts(root):
        for name, signal in part.exports.items():
            names.setdefault(path + inside(part, signal), path + name)
    return names


def open_inputs(flat: FlatGraph) -> list[Problem]:
    """Return exported inputs without a value: graphs with such cannot run alone."""
    driven, found = {wire.target for wire in flat.wires}, list[Problem]()
    message = "the exported input is driven by nothing: the graph is a part of others and cannot run alone"
    for name, (_, what) in exported(flat).items():
        signal = flat.exports[name]
        if isinstance(what, Port) and is_input(flat, signal) and what.default is None and signal not in driven:
            expected = f"a graph that uses this one and wires {name}"
            hint = f'use it as a block, graph = "FILE.toml", or wire a source to {flat.root.exports[name]} here'
            found.append(flat.placed(Problem(message=message, expected=expected, hint=hint, path=("exports", name))))
    return found


def runs_alone(flat: FlatGraph) -> bool:
    """Return whether a graph without problems has a rate and drives its exported inputs itself."""
    rated = flat.rate is not None or all(name in flat.rates or type(b).continuous() for name, b in flat.blocks.items())
    return rated and not open_inputs(flat)


def is_input(flat: FlatGraph, signal: str) -> bool:
    name, port = split(signal)
    return name in flat.blocks and port in type(flat.blocks[name]).inputs
