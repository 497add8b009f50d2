"""Sentences of the documents: none has more than thirty words."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from docs.site.stage import repository_pages

ROOT = Path(__file__).parents[2]
MOST_WORDS = 30
PAGES = sorted({ROOT / "README.md", *repository_pages()})
NOT_PROSE = re.compile(r"\s*(#|!\[|\|?[-:| ]+\|?$)")  # headings, pictures, lines below the head of a table
ITEM = re.compile(r"\n\s*\n|\n(?=\s*(?:[-*]|\d+\.|:) )|\n(?=\|)")
END = re.compile(r"(?<=[.?!])[)\"*]*\s+(?=[A-Z\"(\[*0-9]|code\b)|\s\|\s")


def sentences(text: str) -> Iterator[str]:
    """Yield the sentences of a page, and the cells of its tables; code between ticks counts as one word."""
    text = re.sub(r"^```.*?^```$|(?<=\n\n)(?:    [^\n]*\n)+", "\n\n", text, flags=re.DOTALL | re.MULTILINE)
    text = "\n".join("" if NOT_PROSE.match(line) else line for line in text.splitlines())
    for item in ITEM.split(re.sub(r"`[^`]*`", "code", text)):
        flat = re.sub(r"\]\([^)]*\)", "]", " ".join(item.split())).strip("| ")
        yield from filter(None, END.split(flat))


def words(sentence: str) -> int:
    """Return the number of words; a dash or a sign between blanks is none."""
    return sum(any(letter.isalnum() for letter in word) for word in sentence.split())


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_sentences_are_short(page: Path) -> None:
    long = [text for text in sentences(page.read_text(encoding="utf-8")) if words(text) > MOST_WORDS]
    assert long == []


def test_sentences_end_at_stops_and_cells() -> None:
    prose = "One `a b. c` is. [Two](x.md) e.g. small: yes; no\nmore!"
    page = f"# Title\n\n{prose}\n\n| a | b c |\n|---|---|\n- item\n\n    code code\n\nLast.\n\n```\nx. Y\n```"
    expected = ["One code is.", "[Two] e.g. small: yes; no more!", "a", "b c", "- item", "Last."]
    assert list(sentences(page)) == expected
    assert words("three words - here") == 3
