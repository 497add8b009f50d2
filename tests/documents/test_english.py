"""English of docstrings, by the rules of docs/contributing.md."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROOMS = ("blocks", "graphs", "runner")
RIDDLES = re.compile(r"(What|Whether|How|Where|Why|Which|Of|By|As|But|In so|The same|Those|These|Some of)\b")
BEGUN = re.compile(rf'"""\s*{RIDDLES.pattern}')


def docstrings(path: Path) -> Iterator[tuple[int, str]]:
    """Line and text of each docstring of a file; a file is read through only if a text in it begins like a riddle."""
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text if BEGUN.search(text) else "")
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and (text := ast.get_docstring(node)):
            yield getattr(node, "lineno", 1), text


@pytest.mark.parametrize("room", ROOMS)
def test_docstrings_begin_with_a_verb_or_a_noun(room: str) -> None:
    wrong = [
        f"{path.relative_to(ROOT)}:{line}: {text.splitlines()[0]}"
        for path in sorted((ROOT / room).rglob("*.py"))
        for line, text in docstrings(path)
        if RIDDLES.match(text)
    ]
    assert wrong == []
