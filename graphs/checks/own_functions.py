"""Problems with the functions of a user's own blocks, for all kinds in a graph."""

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.flatten import FlatGraph
from proofmass.graphs.model.graph import split


def own_problems(graph: FlatGraph) -> list[Problem]:
    """Return the problems of a flat graph's own blocks, with file and line; once for each kind."""
    kinds = {type(block) for block in graph.blocks.values() if not block.__module__.startswith("proofmass.blocks.")}
    if not kinds:
        return []
    # start-up time: only graphs with own blocks need the language
    from proofmass.blocks.language.forms import driven_problems, problems_of

    targets = (split(wire.target) for wire in graph.wires)
    kinds_of_ports = [(type(graph.blocks[name]), port) for name, port in targets if name in graph.blocks]
    driven = {kind for kind, port in kinds_of_ports if port in kind.parameters}
    found = [problem for kind in sorted(kinds, key=_name) for problem in problems_of(kind)]
    found += [problem for kind in sorted(kinds & driven, key=_name) for problem in driven_problems(kind)]
    return list(dict.fromkeys(found))


def _name(kind: type[Block]) -> str:
    return kind.__qualname__
