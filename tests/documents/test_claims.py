"""What the documents refer to exists: tests, files, targets of make, commands."""

import ast
import re
from pathlib import Path

import pytest

from proofmass.runner.command_line import cli

ROOT = Path(__file__).parents[2]
PAGES = [
    *(ROOT / name for name in ("CLAIMS.md", "KNOWN_GAPS.md", "README.md")),
    *sorted((ROOT / "docs").glob("*.md")),
    *sorted((ROOT / "docs" / "papers").glob("*.md")),
    *sorted((ROOT / "docs" / "decisions").glob("*.md")),
]
ROOMS = ("blocks", "graphs", "runner", "tests", "benchmarks", "docs", "src")


def code_of(page: Path) -> list[str]:
    """Everything that a page sets as code within its text."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    return re.findall(r"`([^`\n]+)`", text)


def names_of_tests(path: Path) -> set[str]:
    """Names of the test functions of a file, those of classes included."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_what_a_page_names_exists(page: Path) -> None:
    targets = set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    for code in code_of(page):
        file, _, test = code.partition("::")
        placeholder = re.search(r"FAMILY|NAME", file)
        if "/" in file and file.partition("/")[0] in ROOMS and re.fullmatch(r"[\w./-]+", file) and not placeholder:
            assert (ROOT / file).exists(), code
        if test:
            assert test in names_of_tests(ROOT / file), code
        if code.startswith("make "):
            assert code.split()[1] in targets, code
        if re.match(r"proofmass [a-z]", code):
            assert code.split()[1] in cli.commands, code


@pytest.mark.friendly(40, "every promise names its tests")
def test_every_claim_and_every_promise_has_something_that_shows_it() -> None:
    rows = [line for line in (ROOT / "CLAIMS.md").read_text().splitlines() if line.startswith("| ")][1:]
    assert len(rows) > 30
    for row in rows:
        assert re.search(r"`(tests/|benchmarks/|make |proofmass )", row.split("|")[2]), row
    promises = re.split(r"^\*\*\d\. ", (ROOT / "docs" / "promises.md").read_text(), flags=re.MULTILINE)[1:]
    assert len(promises) == 7
    for promise in promises:
        assert "`tests/" in promise.partition("\n## ")[0], promise[:60]
