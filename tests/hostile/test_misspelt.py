"""Every name of every library graph, misspelt by one edit: always refused, and the right name is in the hint."""

import random
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from proofmass.graphs.files.locate_keys import locate_keys
from tests.by_hand.amounts import amounts
from tests.by_hand.graph_texts import WALKED, problems_of

LETTERS = "abcdefghijklmnopqrstuvwxyz"
RIGHT = 0.95  # of the hints must give the right name


class Name(NamedTuple):
    """One place of a name in a text."""

    word: str
    start: int


def names_of(text: str) -> Iterator[Name]:
    """Keys, block names, kinds, and the blocks and ports in wires, probes and exports: all but values and comments.

    The names of exports, measures, requirements, and of what is free or a goal of a tuning are the file's to choose.
    """
    tables = re.finditer(
        r"^\[(?:measures|requirements|tune\.\w+)\].*?\n(.*?)(?=^\[|\Z)", text, re.MULTILINE | re.DOTALL
    )
    chosen = {place for table in tables for place in range(*table.span(1))}
    for found in re.finditer(r"^(\w+) = (?!\"\w+\.\w+\"$)|^\[blocks\.(\w+)\]|^kind = \"(\w+)\"", text, re.MULTILINE):
        for group in (1, 2, 3):
            if found[group] and found.start(group) not in chosen:
                yield Name(found[group], found.start(group))
    declared = set(re.findall(r"^\[blocks\.(\w+)\]", text, re.MULTILINE))
    for found in re.finditer(r"\"(\w+)\.(\w+)(?: -> (\w+)\.(\w+))?\"", text):
        for group in (1, 2, 3, 4):
            if found[group] and found[1] in declared:
                yield Name(found[group], found.start(group))


def edited(word: str, draw: random.Random) -> str:
    """One letter dropped, doubled, replaced, inserted, or swapped with the next."""
    at = draw.randrange(len(word))
    letter = draw.choice(LETTERS)
    ways = [
        word[:at] + word[at + 1 :],
        word[:at] + word[at] + word[at:],
        word[:at] + letter + word[at + 1 :],
        word[: at + 1] + letter + word[at + 1 :],
        word[:at] + word[at + 1 : at + 2] + word[at] + word[at + 2 :],
    ]
    return draw.choice(ways)


def misspellings(text: str, draw: random.Random, tries: int) -> Iterator[tuple[Name, str]]:
    """About so many; of few tries a part of the names, else each of them at least once."""
    taken = {name.word for name in names_of(text)} | {part for path in locate_keys(text) for part in path}
    names = list(names_of(text))
    for name in names[:: max(1, len(names) // tries)]:
        for _ in range(1 + tries // len(names)):
            wrong = edited(name.word, draw)
            if wrong and wrong not in taken:
                yield name, wrong


@pytest.mark.exhaustive(but=4)
@pytest.mark.parametrize("tries", amounts(20, 120))
@pytest.mark.parametrize("path", WALKED)
@pytest.mark.friendly(8, "misspelt names in every graph of the library")
def test_a_misspelt_name_is_refused_and_the_right_one_offered(path: Path, tries: int) -> None:
    text = path.read_text(encoding="utf-8")
    draw = random.Random(path.stem)
    tried, missed = 0, []
    for name, wrong in misspellings(text, draw, tries):
        damaged = text[: name.start] + wrong + text[name.start + len(name.word) :]
        problems = problems_of(damaged, folder=str(path.parent))
        refusals = [problem for problem in problems if not problem.note]
        assert refusals, f"{name.word} as {wrong} was taken"
        line = text.count("\n", 0, name.start) + 1
        tried += 1
        # A block's own name stands in its header: the wires to it are what is wrong then.
        if not any(re.search(rf"\b{name.word}\b", problem.hint) for problem in refusals):
            missed.append(f"line {line}: {name.word} as {wrong}: {refusals[0]}")
    assert tried > tries / 2.4
    assert len(missed) <= (1 - RIGHT) * tried, "\n".join(missed)
