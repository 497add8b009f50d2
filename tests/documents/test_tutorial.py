"""The tutorial, followed from an empty folder: every file is written, every command answers as its page says."""

from pathlib import Path

import pytest

from docs.site.pictures import DIAGRAMS, PLOTS, STEPS
from docs.site.play import missing_lines, play
from proofmass.graphs.drawing.diagram import svg
from proofmass.graphs.files.toml_reader import read_graph

PICTURES = Path(__file__).parents[2] / "docs" / "pictures"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The one folder of the reader, in which each step finds what the steps before it wrote."""
    return tmp_path_factory.mktemp("tutorial")


@pytest.mark.parametrize("step", STEPS, ids=lambda step: step.stem)
def test_step(step: Path, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    commands = list(play(step))
    assert commands
    for command in commands:
        assert command.status == command.expected_status, f"{command.text}\n{command.output}"
        assert missing_lines(command.output, command.promised) == [], f"{command.text}\n{command.output}"


def test_pictures_are_those_of_the_files(folder: Path) -> None:
    for file, picture in DIAGRAMS.items():
        assert (PICTURES / picture).read_text(encoding="utf-8") == svg(read_graph(folder / file)), picture
    for file, picture in PLOTS.items():
        assert (folder / file).exists()
        assert (PICTURES / picture).read_text(encoding="utf-8").startswith("<?xml")


def test_a_line_that_is_missing_is_noticed() -> None:
    assert missing_lines("a 1.00\nb 2", "a 1.01\nb 3") == ["b 3"]
    assert missing_lines("b 2\na 1", "a 1\nb 2") == ["b 2"]
