"""Every fenced graph, program and command of the docs runs and answers as the page says; every link leads somewhere."""

import re
import runpy
import shlex
import shutil
from pathlib import Path
from typing import Any

import pytest

from docs.papers import pn_self_calibration
from docs.papers.quartz_accelerometer import tables
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.library import library_files
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.top_keys import TOP_KEYS
from proofmass.runner.command_line import main
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.simulate import simulate

DOCS = Path(__file__).parents[2] / "docs"
WRITTEN = sorted([*DOCS.glob("*.md"), *(DOCS / "papers").glob("*.md")])  # pages whose commands and graphs are run
TICKS_IN_PLAIN_PYTHON = 5_000  # at most, of those of a graph of the docs
COMMANDS = [
    pytest.param(commands, answer, id=f"{path.stem}-{number}")
    for path in WRITTEN
    for number, (commands, answer) in enumerate(
        re.findall(r"^```sh\n(.*?)^```$(?:\n\n^```text\n(.*?)^```$)?", path.read_text(), re.DOTALL | re.MULTILINE)
    )
]


def fenced(language: str) -> list[Any]:
    return [
        pytest.param(text, id=f"{path.stem}-{number}")
        for path in WRITTEN
        for number, text in enumerate(
            re.findall(rf"^```{language}\n(.*?)^```$", path.read_text(), re.DOTALL | re.MULTILINE)
        )
    ]


def test_every_fence_says_what_it_is() -> None:
    languages = {
        language
        for path in WRITTEN
        for language in re.findall(r"^```(\w*)\n(?:.*?)^```$", path.read_text(), re.DOTALL | re.MULTILINE)
    }
    assert languages <= {"toml", "python", "sh", "text", "verilog"}, "a new kind of block needs a test that runs it"
    assert fenced("toml")


@pytest.mark.exhaustive("noise-1", "noise-2")
@pytest.mark.parametrize("text", fenced("python"))
def test_program(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder_of_files(tmp_path))
    (tmp_path / "example.py").write_text(text)
    runpy.run_path(str(tmp_path / "example.py"))


def test_verilog_is_what_the_program_before_it_writes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    ((program, verilog),) = re.findall(
        r"^```python\n((?:(?!^```).)*?)^```$(?:(?!^```).)*?^```verilog\n(.*?)^```$",
        (DOCS / "rtl.md").read_text(),
        re.DOTALL | re.MULTILINE,
    )
    (tmp_path / "smoother.py").write_text(program)
    runpy.run_path("smoother.py")
    assert (tmp_path / "smoother.v").read_text() == verilog


@pytest.mark.exhaustive
def test_tables_of_the_quartz_accelerometer_are_those_printed() -> None:
    page = (DOCS / "papers/quartz-accelerometer.md").read_text()
    fences = re.findall(r"^```text\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    printed = "\n".join(tables()) + "\n"
    assert len(fences) == 5
    assert [text for text in fences if text not in printed] == []


@pytest.mark.exhaustive
def test_tables_of_the_self_calibration_are_those_printed() -> None:
    """Those that take no minutes; tests/reference holds the numbers of the others."""
    page = (DOCS / "papers/pn-self-calibration.md").read_text()
    fences = re.findall(r"^```text\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    assert len(fences) == len(pn_self_calibration.TABLES)
    for table in pn_self_calibration.QUICK:
        assert pn_self_calibration.printed(table) + "\n" in fences


@pytest.mark.exhaustive("graph-files-5", "quartz-accelerometer-0")
@pytest.mark.parametrize("text", fenced("toml"))
def test_graph(text: str) -> None:
    graph = read_graph_text(text)
    assert check(graph) == []
    compiled = simulate(graph, engine="compiled")
    python = simulate(graph, engine="python", samples=min(plan(graph).ticks(), TICKS_IN_PLAIN_PYTHON))
    for name in python:
        values = python[name].values
        assert (values == compiled[name].values[: len(values)]).all()


@pytest.mark.exhaustive(
    "README-0",
    "design_loop-0",
    "margins-0",
    "pn-self-calibration-4",
    "pn-self-calibration-6",
    "pn-self-calibration-7",
    "temperature-compensation-0",
    "temperature-compensation-1",
    "temperature-compensation-2",
    "requirements-0",
    "rtl-1",
    "studies-0",
    "pn-self-calibration-5",
    "pn-self-calibration-8",
    "quartz-accelerometer-0",
    "quartz-accelerometer-1",
    "rtl-0",
    "rtl-2",
)
@pytest.mark.parametrize(("commands", "answer"), COMMANDS)
def test_commands(
    commands: str, answer: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """In a copy of the library; numbers of the answer within a twentieth, since iterations may differ by one."""
    monkeypatch.chdir(folder_of_files(tmp_path))
    for line in commands.splitlines():
        program, *arguments = shlex.split(line)
        assert program == "proofmass"
        assert main(arguments) == 0, capsys.readouterr().err
    if answer:
        found, promised = ([_value(word) for word in text.split()] for text in (capsys.readouterr().out, answer))
        assert found == [pytest.approx(word, rel=5e-2) if isinstance(word, float) else word for word in promised]


def folder_of_files(path: Path) -> Path:
    """A copy of the library, with every graph of the docs whose first line says its name: `# loop.toml`."""
    folder = path / "library"
    folder.mkdir()
    for file in library_files().values():
        shutil.copy(file, folder)
    for (text,) in (param.values for param in fenced("toml")):
        name = re.match(r"# (\w+\.toml)\n", text)
        if name:
            (folder / name[1]).write_text(text)
    return folder


def _value(word: str) -> str | float:
    try:
        return float(word.replace(",", ""))
    except ValueError:
        return word


def test_every_key_of_a_file_is_explained() -> None:
    page = (DOCS / "graph-files.md").read_text()
    for key in TOP_KEYS:
        assert f"`{key}`" in page or f"[{key}." in page, key


PAGES = sorted([*DOCS.rglob("*.md"), *DOCS.parent.glob("*.md")])


@pytest.mark.parametrize("path", PAGES, ids=lambda path: str(path.relative_to(DOCS.parent)))
def test_links(path: Path) -> None:
    for link in re.findall(r"\]\(([^)#]+)\)", path.read_text()):
        assert "://" in link or (path.parent / link).exists(), link
