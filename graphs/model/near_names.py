"""Hints for names not written as names, and wires without ports: what was meant."""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Port
from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.problem import Problem, nearest
from proofmass.blocks.declaration.unit_expressions import UnitError
from proofmass.blocks.declaration.units import same_unit
from proofmass.graphs.model.limits import NAME

_OF_SIGNALS = ("not a wire", "not a probe", "not an output")
_WORD = re.compile(r"[^\s.'\"{}=,>-]+")
_LONGEST = 200  # characters of a text that is searched for a name
_SHOWN = 3  # wires in a hint


def with_nearest(
    problems: Iterable[Problem], blocks: Mapping[str, object], wires: Sequence[object]
) -> Iterator[Problem]:
    """Yield problems, of names with the nearest block or wire name."""
    missing: set[str] | None = None
    for problem in problems:
        whole = whole_wire(wires[int(problem.path[1])], blocks) if problem.message == "not a wire" else ""
        if whole:
            yield replace(problem, hint=whole)
        elif (
            problem.message in _OF_SIGNALS
            and len(problem.got) <= _LONGEST
            and "names are lower case" not in problem.hint
        ):
            yield replace(problem, hint=_of_signal(problem.got, blocks) or problem.hint)
        elif problem.message == "not a name" and problem.key == "blocks" and not problem.hint:
            if missing is None:
                missing = {word for wire in wires for word in _blocks_of(wire)} - set(blocks)
            near = nearest(problem.got.strip("'"), missing)
            yield replace(problem, hint=f"did you mean {near}?" if near else "")
        else:
            yield problem


def _of_signal(text: str, blocks: Collection[str]) -> str:
    """A hint with the nearest block of each word of a text that names no block."""
    wrong = [word for word in _WORD.findall(text) if not NAME.fullmatch(word)]
    near = dict.fromkeys(filter(None, (nearest(word, blocks) for word in wrong)))
    return f"did you mean {' and '.join(near)}?" if near else ""


def _blocks_of(wire: object) -> Iterator[str]:
    """Names of blocks in the text of a wire."""
    if isinstance(wire, str) and len(wire) <= _LONGEST:
        for end in wire.split("->"):
            name = end.strip().partition(".")[0]
            if NAME.fullmatch(name):
                yield name


class _End(NamedTuple):
    """An end that may have been meant."""

    signal: str
    block: Block
    port: Port


def whole_wire(wire: object, blocks: Mapping[str, object]) -> str:
    """Return a hint for a wire such as "inertia -> sensor"; empty where the blocks are not known.

    >>> from proofmass.blocks import Gain, Step
    >>> whole_wire("step -> gain", {"step": Step(), "gain": Gain()})
    'write "step.output -> gain.input"'
    """
    ends = ends_of(wire)
    if len(ends) != 2:
        return ""
    sources, targets = (list(_ends(end, blocks, number)) for number, end in enumerate(ends))
    wires = [(source, target) for source in sources for target in targets]
    meant = [wire for wire in wires if _fit(*wire)] or wires
    written = [f'"{source.signal} -> {target.signal}"' for source, target in meant]
    return f"write {' or '.join(written[:_SHOWN])}" if written else ""


def ends_of(wire: object) -> list[str]:
    """Return the ends of a wire: of a text with arrows, a list, or a table with `from` and `to`."""
    if isinstance(wire, str):
        return [end.strip() for end in wire.split("->", 2)]
    if isinstance(wire, Mapping):
        wire = [wire[side] for side in sorted(wire, key=lambda side: side in ("to", "target", "sink"))]
    entries = list(wire) if isinstance(wire, list | tuple) else []
    return [entry.strip() for entry in entries] if [type(entry) for entry in entries] == [str, str] else []


def _ends(text: str, blocks: Mapping[str, object], number: int) -> Iterator[_End]:
    """Yield the ports an end may mean: the named one, or all outputs or inputs of the block."""
    name, dot, port = text.partition(".")
    block = blocks.get(name)
    if isinstance(block, Block):
        ports = type(block).inputs if number else type(block).outputs
        named = {port: ports[port]} if port in ports else {} if dot else ports
        yield from (_End(f"{name}.{key}", block, one) for key, one in named.items())


def _fit(source: _End, target: _End) -> bool:
    try:
        same = same_unit(unit_of(source.block, source.port), unit_of(target.block, target.port))
    except UnitError:
        return False
    return same and source.port.dtype is target.port.dtype and bool(source.port.shape) == bool(target.port.shape)
