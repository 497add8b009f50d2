"""The tutorial, followed from an empty folder: every file is written, every command answers as its page says."""

import contextlib
from pathlib import Path
from typing import NamedTuple

import pytest

from docs.site.pictures import DIAGRAMS, PLOTS, STEPS
from docs.site.play import Command, missing_lines, play
from proofmass.graphs.drawing.diagram import svg
from proofmass.graphs.files.toml_reader import read_graph

PICTURES = Path(__file__).parents[2] / "docs" / "pictures"


class Tutorial(NamedTuple):
    """The one folder of the reader, and what the commands of each step answered in it."""

    folder: Path
    answers: dict[Path, list[Command]]


@pytest.fixture(scope="module")
def tutorial(tmp_path_factory: pytest.TempPathFactory) -> Tutorial:
    """All steps, one after the other: each finds what those before it wrote."""
    folder = tmp_path_factory.mktemp("tutorial")
    with contextlib.chdir(folder):
        return Tutorial(folder, {step: list(play(step)) for step in STEPS})


@pytest.mark.friendly(37, "the tutorial runs from an empty folder")
def test_every_step_answers_as_its_page_says(tutorial: Tutorial) -> None:
    for step in STEPS:
        assert tutorial.answers[step], step
        for command in tutorial.answers[step]:
            assert command.status == command.expected_status, f"{command.text}\n{command.output}"
            assert missing_lines(command.output, command.promised) == [], f"{command.text}\n{command.output}"


def test_pictures_are_those_of_the_files(tutorial: Tutorial) -> None:
    folder = tutorial.folder
    for file, picture in DIAGRAMS.items():
        assert (PICTURES / picture).read_text(encoding="utf-8") == svg(read_graph(folder / file)), picture
    for file, picture in PLOTS.items():
        assert (folder / file).exists()
        assert (PICTURES / picture).read_text(encoding="utf-8").startswith("<?xml")


def test_a_line_that_is_missing_is_noticed() -> None:
    assert missing_lines("a 1.00\nb 2", "a 1.01\nb 3") == ["b 3"]
    assert missing_lines("b 2\na 1", "a 1\nb 2") == ["b 2"]
