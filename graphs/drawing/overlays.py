"""Overlays of a diagram: rates, control loops, and types of signals with fixed-point formats."""

from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property

from proofmass.graphs.drawing.picture import Box
from proofmass.graphs.drawing.style import SHADES
from proofmass.graphs.model.digraph import loops
from proofmass.graphs.model.flatten import FlatGraph, inside
from proofmass.graphs.model.graph import split
from proofmass.graphs.model.rates import write_rate

_CONTINUOUS = "continuous"


class Overlays:
    """Classes of blocks and wires by what they share, each with a shade of its own."""

    def __init__(self, flat: FlatGraph) -> None:
        self.flat = flat
        self.rates = list[str]()
        self.formats = list[str]()

    @cached_property
    def loops(self) -> Mapping[str, frozenset[str]]:
        """Blocks of each control loop by its name; of every loop where none is named."""
        before: dict[str, list[str]] = {name: [] for name in self.flat.blocks}
        for wire in self.flat.wires:
            source, target = split(wire.source)[0], split(wire.target)[0]
            if source in before and target in before:
                before[target].append(source)
        together = sorted((frozenset(part) for part in loops(before)), key=min)
        named = {
            name: next((part for part in together if split(inside(self.flat.root, loop.open_at))[0] in part), None)
            for name, loop in self.flat.loops.items()
        }
        found = {name: part for name, part in named.items() if part}
        return found or {f"loop of {min(part)}": part for part in together}

    def of_block(self, box: Box) -> Iterator[str]:
        """Yield the classes of a block, or of a subgraph: its rate if it has but one, its loops."""
        inner = [name for name in self.flat.blocks if name.startswith(f"{box.path}.")] if box.subgraph else [box.path]
        rates = {self._rate(name) for name in inner}
        if len(rates) == 1:
            yield f"rate{_shade(self.rates, rates.pop())}"
        for number, blocks in enumerate(self.loops.values()):
            if not blocks.isdisjoint(inner):
                yield f"loop{number % SHADES}"

    def of_wire(self, signal: str, target: str, kind: str) -> Iterator[str]:
        """Yield the classes of a wire by its ends' flat names and its type: loops, format."""
        ends = {split(signal)[0], split(target)[0]}
        for number, blocks in enumerate(self.loops.values()):
            if ends <= blocks:
                yield f"loop{number % SHADES}"
        yield self.format(kind)

    def format(self, kind: str) -> str:
        """Return the class of a type."""
        return f"format{_shade(self.formats, kind)}"

    def legend(self) -> Mapping[str, Iterable[tuple[str, str]]]:
        """Return for each overlay the class and the words of what has been drawn so far."""
        return {
            "rates": _entries("rate", self.rates),
            "loops": _entries("loop", list(self.loops)) or [("", "no loops")],
            "formats": _entries("format", self.formats),
        }

    def _rate(self, name: str) -> str:
        rate = self.flat.rates.get(name, self.flat.rate)
        return _CONTINUOUS if type(self.flat.blocks[name]).continuous() or rate is None else write_rate(rate)


def _entries(kind: str, texts: list[str]) -> list[tuple[str, str]]:
    return [(f"{kind}{number % SHADES}", text) for number, text in enumerate(texts)]


def _shade(known: list[str], text: str) -> int:
    if text not in known:
        known.append(text)
    return known.index(text) % SHADES
