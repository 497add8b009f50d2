"""The list of `make derivations`: what each block of the rooms of physics was compared with, by a second person.

A test takes part by its marker:

    @pytest.mark.derivation(
        CombDrive,
        equation="F = dW/dx of the energy between the fingers",
        source="Maxwell's stress, integrated over a finger",
        convention="two gaps a pair of fingers; C' is of one comb",
        wrong="",
    )

`source` is where the reference comes from, which is never the block; `convention` is what a reader may get wrong by a
factor: one- or two-sided, rms or peak, angle or turns, shell or mode, LSB of the full scale or of half. `wrong` names
what the comparison found, with its defect. It is left out where nothing was.
"""

import ast
from collections.abc import Sequence
from pathlib import Path

import pytest

from tests.marked import MarkedTable, Row

ROOMS = ("mechanics", "optics", "magnetics", "oscillators", "converters")
FACTS = ("equation", "source", "convention")


class DerivationTable(MarkedTable):
    """Prints each block with its equation, source, convention and what was wrong."""

    marker = "derivation"

    def row(self, mark: pytest.Mark) -> Row:
        """Room, block, the three facts and what was wrong."""
        kind = mark.args[0]
        facts = [str(mark.kwargs[name]) for name in FACTS]
        return kind.__module__.split(".")[-2], kind.__name__, *facts, mark.kwargs.get("wrong", "")

    def lines(self, row: Row, test: str, outcome: str) -> list[str]:
        """A line for each fact."""
        room, block, *facts, wrong = row
        named = zip(FACTS, facts, strict=True)
        lines = [f"{block} ({room}), {test.rpartition('::')[2]}: {outcome}"]
        lines += [f"      {name + ':':<12}{fact}" for name, fact in named]
        return [*lines, f"      wrong:      {wrong or 'nothing'}"]

    def summary(self, rows: Sequence[Row]) -> str:
        """How many blocks there are in each room, and in how many of all something was wrong."""
        blocks = {(row[0], row[1]) for row in rows}
        counts = [f"{sum(room == name for name, _ in blocks)} of {room}" for room in ROOMS]
        wrong = {row[1] for row in rows if row[-1]}
        return f"{len(blocks)} blocks, {', '.join(counts)}: something was wrong in {len(wrong)}"


def derivations(path: Path) -> list[dict[str, str]]:
    """Return what each mark in a file of tests says, its block under the key `block`."""
    marks = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "pytest.mark.derivation":
            facts = {word.arg: ast.literal_eval(word.value) for word in node.keywords if word.arg}
            marks.append({"block": ast.unparse(node.args[0]), **facts})
    return marks
