"""Every fenced graph of the docs is whole and runs; every link leads somewhere."""

import re
from pathlib import Path

import pytest

from proofmass.graphs.check import check
from proofmass.graphs.toml_reader import TOP_KEYS, read_graph_text
from proofmass.runner.simulate import simulate

DOCS = Path(__file__).parents[2] / "docs"
FENCED = [
    pytest.param(text, id=f"{path.stem}-{number}")
    for path in sorted(DOCS.glob("*.md"))
    for number, text in enumerate(re.findall(r"^```toml\n(.*?)^```$", path.read_text(), re.DOTALL | re.MULTILINE))
]


def test_every_fence_says_what_it_is() -> None:
    languages = {
        language
        for path in DOCS.glob("*.md")
        for language in re.findall(r"^```(\w*)\n(?:.*?)^```$", path.read_text(), re.DOTALL | re.MULTILINE)
    }
    assert languages <= {"toml"}, "a new kind of block needs a test that runs it"
    assert FENCED


@pytest.mark.parametrize("text", FENCED)
def test_graph(text: str) -> None:
    graph = read_graph_text(text)
    assert check(graph) == []
    python, compiled = (simulate(graph, engine=engine) for engine in ("python", "compiled"))
    for name in python:
        assert (python[name].values == compiled[name].values).all()


def test_every_key_of_a_file_is_explained() -> None:
    page = (DOCS / "graph-files.md").read_text()
    for key in TOP_KEYS:
        assert f"`{key}`" in page or f"[{key}." in page, key


@pytest.mark.parametrize("path", sorted(DOCS.glob("*.md")), ids=lambda path: path.stem)
def test_links(path: Path) -> None:
    for link in re.findall(r"\]\(([^)#]+)\)", path.read_text()):
        assert "://" in link or (path.parent / link).exists(), link
