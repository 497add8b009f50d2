"""Mistakes that only Python allows: blocks without names, values assigned to a graph, functions taken for methods."""

import re
from collections.abc import Mapping
from itertools import count

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.other_functions import drawn_by, function_of
from proofmass.blocks.declaration.problem import Problem, shown
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.targets import DURATION, RATE

_OF_OTHERS = ("read_graph", "spectrum", "tones", "allan", "run_study")  # functions of something else than a graph
_CHANGES = ("set", "set_parameter", "set_parameters", "with_parameter", "update", "replace")
CAPITALS = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")  # where ReadOut becomes read_out


def refuse_unnamed(blocks: object) -> None:
    """Raise `ModelError` unless blocks are a table; the hint is the table that was meant, as far as it can be told."""
    if isinstance(blocks, Mapping):
        return
    entries = blocks if isinstance(blocks, list | tuple) else [blocks]
    written = {}
    for block in (entry for entry in entries if isinstance(entry, Block)):
        name = CAPITALS.sub("_", type(block).__name__).lower()
        free = (f"{name}_{number}" if number > 1 else name for number in count(1))
        written[next(one for one in free if one not in written)] = block
    table = ", ".join(f'"{name}": {block!r}' for name, block in written.items()) or '"gain": Gain()'
    hint = f"give each block a name: blocks={{{table}}}"
    message = "the blocks have no names" if isinstance(blocks, list | tuple) else "must be a table of blocks by name"
    raise Problem(message=message, key="blocks", got=shown(blocks), hint=hint).error


def assigned(name: str) -> str:
    """Return what to say of an assignment to an attribute of a graph."""
    if name in (RATE, DURATION):
        cure = f'graph = graph.with_parameters({{"{name}": ...}})'
    elif name in Graph.__dataclass_fields__:
        cure = f"graph = graph.changed({name}=...)"
    else:
        cure = 'graph = graph.with_parameters({"block.parameter": ...})'
    return f"cannot assign to {name}: a graph is a frozen value; {cure}"


def asked(name: str) -> str:
    """Return what to say of an attribute that a graph does not have."""
    missing = f"a graph has no attribute {name!r}"
    if name in _CHANGES:
        return f'{missing}; graph.with_parameters({{"block.parameter": ...}}) returns a changed graph'
    if drawn_by(name):
        return f"{missing}; {drawn_by(name)}"
    function = function_of(name)
    if not function or function in _OF_OTHERS:
        return missing
    return f"{missing}; {function} is a function: proofmass.{function}(graph)"
