"""Every block of the README runs, and what it prints is what the README says; so do the first pages after it."""

import contextlib
import json
import os
import re
import shutil
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from proofmass import read_study, run_study
from proofmass.graphs.files.library import library_file
from proofmass.runner.command_line import main

ROOT = Path(__file__).parents[2]


def fences(page: str) -> list[tuple[str, str]]:
    """Return language and text of each fenced block of a page."""
    text = (ROOT / page).read_text(encoding="utf-8")
    return re.findall(r"^```(\w+)\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = fences("README.md")
GRAPH = next(text for language, text in fences("docs/tutorial/1-first-sensor.md") if language == "toml")
PYTHON = [text for language, text in BLOCKS if language == "python"]
COMMANDS = [line for language, text in BLOCKS if language == "sh" for line in text.splitlines() if line.strip()]


def run(command: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """A command in a folder, with the `proofmass` of this environment first on the path."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "PYTHONPATH": str(ROOT / "src")}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=120)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the graph file of the tutorial's first step."""
    (tmp_path / "accelerometer.toml").write_text(GRAPH, encoding="utf-8")
    return tmp_path


def test_there_is_something_to_test() -> None:
    assert {language for language, _ in BLOCKS} == {"sh", "python"}
    assert len(PYTHON) == 1
    assert len([c for c in COMMANDS if c.startswith("proofmass")]) >= 5


def test_it_is_one_screen() -> None:
    assert len(README.splitlines()) <= 70


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.friendly(2, "each command of the README runs and says what is printed")
def test_command(
    command: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One of them as a person starts it, the others in this process."""
    words = command.partition("#")[0].split()
    monkeypatch.chdir(folder)
    if words[1] != "new":
        shutil.copy(library_file("template.toml"), folder / "sensor.toml")
    if words[0] == "make":
        done = run([*words, "-n", "-C", str(ROOT)], folder)
        assert any(what in done.stdout for what in ("pip install", "benchmarks.self_test", "pytest"))
        assert done.returncode == 0, done.stderr
    elif words[1] == "run":
        done = run([sys.executable, "-m", "proofmass", *words[1:]], folder)
        assert done.returncode == 0, done.stderr
        assert "Traceback" not in done.stderr
    else:
        status, said = main(words[1:]), capsys.readouterr()
        assert status == 0, said.err
        assert "Traceback" not in said.err


@pytest.mark.exhaustive
def test_workers_of_a_scheduler(folder: Path) -> None:
    """The three lines of the laptop, at any port that is free."""
    lines = next(text for _, text in fences("docs/how-to/cluster.md") if "dask scheduler --host" in text).splitlines()
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = str(free.getsockname()[1])
    scheduler, worker, study = (line.replace("8786", port).split() for line in lines)
    scheduler += ["--port", port, "--no-dashboard"]
    study = ["-m", "proofmass", *study[1:], "--runs", "4", "--json"]
    environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
    with contextlib.ExitStack() as started:
        for words in (scheduler, [*worker, "--no-dashboard"]):
            command = [sys.executable, "-m", "dask", *words[1:]]
            process = started.enter_context(
                subprocess.Popen(command, cwd=folder, env=environment, stderr=subprocess.DEVNULL)
            )
            started.callback(process.terminate)
        done = run([sys.executable, *study], folder)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["digest"] == run_study(read_study(study[3]), runs=4).digest


def test_files_that_the_text_promises(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    assert main(["run", "accelerometer.toml", "--out", "results"]) == 0
    assert {"traces.nc", "plot.svg", "report.html"} <= {path.name for path in (folder / "results").iterdir()}


@pytest.mark.exhaustive
def test_messages_are_the_ones_printed(folder: Path) -> None:
    page = fences("docs/tutorial/2-mistakes.md")
    wrong = next(text for language, text in page if language == "toml")
    promised = next(text for language, text in page if language == "text" and "problems in" in text)
    (folder / "broken.toml").write_text(wrong, encoding="utf-8")
    done = run([sys.executable, "-m", "proofmass", "check", "broken.toml"], folder)
    assert done.returncode == 1
    assert done.stderr == promised


@pytest.mark.exhaustive
@pytest.mark.friendly(2, "its Python example runs")
def test_python_example(folder: Path) -> None:
    (folder / "example.py").write_text(PYTHON[0], encoding="utf-8")
    done = run([sys.executable, "example.py"], folder)
    assert done.returncode == 0, done.stderr
    value, unit = done.stdout.split()
    assert unit == "m"
    assert float(value) == pytest.approx(1e-6 / 49.5627, rel=1e-9)


@pytest.mark.friendly(18, "the block in the README runs")
def test_block_of_your_own(folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    page = fences("docs/how-to/write-a-block.md")
    (folder / "peak.py").write_text(next(text for _, text in page if text.startswith("# peak.py")), encoding="utf-8")
    graph = """
name = "peak"
rate = "1 kHz"
samples = 2000
wires = ["source.output -> detector.voltage"]
probes = ["detector.peak"]
[blocks.source]
kind = "Pulse"
unit = "V"
[blocks.detector]
kind = "PeakDetector"
"""
    (folder / "graph.toml").write_text(graph, encoding="utf-8")
    monkeypatch.chdir(folder)
    for engine in ("python", "compiled"):
        assert main(["run", "graph.toml", "--blocks", "peak.py", "--engine", engine]) == 0
        assert "detector.peak" in capsys.readouterr().out
    assert main(["run", "graph.toml"]) == 1
    assert "PeakDetector" in capsys.readouterr().err


def test_links_and_pictures_exist() -> None:
    links = re.findall(r"\]\(([^)#]+)\)", README)
    local = [link for link in links if "://" not in link]
    assert local
    for link in local:
        assert (ROOT / link).exists(), link


@pytest.mark.friendly(2, "its picture is what the command draws")
def test_picture_is_what_draw_makes() -> None:
    from proofmass.graphs.drawing.diagram import svg
    from proofmass.graphs.files.toml_reader import read_graph

    drawn = svg(read_graph(library_file("pn_self_test_accelerometer.toml")))
    assert (ROOT / "docs" / "pictures" / "pn_self_test_accelerometer.svg").read_text(encoding="utf-8") == drawn
