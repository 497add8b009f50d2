"""Examples in the words of functions that are not public; those that are have theirs run in test_api.py."""

import doctest
import importlib
import linecache
from pathlib import Path

import pytest

import proofmass

ROOT = Path(__file__).parents[2]
FILES = [
    str(path.relative_to(ROOT))
    for room in ("blocks", "graphs", "runner")
    for path in sorted((ROOT / room).rglob("*.py"))
    if ">>> " in path.read_text(encoding="utf-8")
]
PUBLIC = {f"proofmass.{home}.{name}" for name, home in proofmass._HOMES.items()}


@pytest.mark.parametrize("file", FILES)
def test_an_example_says_what_comes_out(file: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(linecache, "checkcache", lambda file=None: None)  # or each looks at every file ever read
    module = importlib.import_module("proofmass." + file.removesuffix(".py").replace("/", "."))
    answers: list[str] = []
    for example in doctest.DocTestFinder().find(module):
        if example.name not in PUBLIC:
            doctest.DocTestRunner(verbose=False, optionflags=doctest.ELLIPSIS).run(example, out=answers.append)
    assert "".join(answers) == ""


def test_examples_are_found() -> None:
    assert len(FILES) > 90
