"""Hints for names that are not written as names may be: the name that was probably meant."""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from proofmass.blocks.declaration.problem import Problem, nearest
from proofmass.graphs.model.limits import NAME
from proofmass.graphs.model.whole_wires import whole_wire

_OF_SIGNALS = ("not a wire", "not a probe", "not an output")
_WORD = re.compile(r"[^\s.'\"{}=,>-]+")
_LONGEST = 200  # characters of a text that is searched for a name


def with_nearest(
    problems: Iterable[Problem], blocks: Mapping[str, object], wires: Sequence[object]
) -> Iterator[Problem]:
    """Yield problems, those of names with the nearest block, or the nearest name that only wires have."""
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
