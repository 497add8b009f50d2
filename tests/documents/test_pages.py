"""Pages of how-to, explanation and comparison: their files are sound, their programs and commands run."""

import re
import runpy
import shutil
from pathlib import Path

import pytest

from benchmarks import peers
from docs.site.play import missing_lines, play
from proofmass.runner.command_line import main

DOCS = Path(__file__).parents[2] / "docs"
FOLDERS = ("how-to", "explanation", "coming-from")
PAGES = sorted(page for folder in FOLDERS for page in (DOCS / folder).glob("*.md"))
PROGRAMS = [
    pytest.param(text, id=f"{page.stem}-{number}")
    for page in PAGES
    for number, text in enumerate(re.findall(r"^```python\n(.*?)^```$", page.read_text(), re.DOTALL | re.MULTILINE))
]
PLAYED = [page for page in PAGES if re.search(r"^```(sh|toml)\n", page.read_text(), re.MULTILINE)]


def test_every_fence_says_what_it_is() -> None:
    for page in [*PAGES, *(DOCS / "tutorial").glob("*.md")]:
        fences = re.findall(r"^```([^\n]*)\n(?:.*?)^```$", page.read_text(), re.DOTALL | re.MULTILINE)
        assert set(fences) <= {"toml", "python", "sh", "text"}, (page, fences)


@pytest.mark.friendly(37, "tasks, words and other tools have pages")
def test_there_is_a_page_for_a_task_a_word_and_a_tool() -> None:
    for folder in ("how-to", "coming-from"):
        index = (DOCS / folder / "index.md").read_text(encoding="utf-8")
        assert all(f"({page.name}" in index for page in (DOCS / folder).glob("*.md") if page.stem != "index"), folder
    terms = re.findall(r"^(\w.*)\n: ", (DOCS / "explanation" / "glossary.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert terms == sorted(terms, key=str.lower)
    assert {"Allan deviation", "base tick", "epoch", "margin", "probe", "seed"} <= {*terms}


@pytest.mark.parametrize("text", PROGRAMS)
@pytest.mark.friendly(37, "so do their programs")
def test_program(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("example.py").write_text(text, encoding="utf-8")
    runpy.run_path("example.py")


def test_the_compared_loops_agree() -> None:
    """Those that need nothing else to be installed; benchmarks/peers.py prints the others too."""
    answers = [peers.by_hand(100), peers.proofmass_loop("python")(100), peers.python_control(100)]
    assert answers == pytest.approx([1.0028136459271] * 3, abs=1e-12)


def test_the_netlist_of_the_page_is_the_one_that_runs() -> None:
    assert peers.NETLIST.read_text() in (DOCS / "coming-from" / "spice.md").read_text()


@pytest.mark.skipif(not shutil.which("ngspice"), reason="needs ngspice")
def test_the_netlist_answers_as_the_graph() -> None:
    assert peers.spice_loop(100) == pytest.approx(1.0028136459271, abs=2e-6)


@pytest.mark.exhaustive("prove", "sigma-delta", "simulink")
@pytest.mark.parametrize("page", PLAYED, ids=lambda page: page.stem)
@pytest.mark.friendly(37, "commands of pages for tasks run as they stand")
def test_commands(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for command in play(page):
        assert command.status == command.expected_status, command.output
        assert missing_lines(command.output, command.promised) == [], command.output
    own = ["--blocks", "peak.py"] if Path("peak.py").exists() else []
    for file in tmp_path.glob("*.toml"):
        assert main(["check", file.name, *own]) == 0, file
