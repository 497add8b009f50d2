"""Overflows are told where a run is read: on the terminal, as JSON, in the summary and in the report; zeros are not."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

import proofmass
from proofmass.runner.command_line import main

GRAPH = """
name = "sawtooth"
rate = "1 kHz"
samples = 1000
wires = ["source.output -> quantiser.input", "quantiser.output -> phase.input"]
probes = ["phase.output"]
[blocks.source]
kind = "Constant"
value = 3
[blocks.quantiser]
kind = "FixedQuantiser"
[blocks.phase]
kind = "FixedIntegrator"
gain = 100
sum_format = "(20, 17)"
output_format = "(20, 17)"
overflow = "OVERFLOW"
"""


@pytest.fixture
def graph(tmp_path: Path) -> Path:
    path = tmp_path / "graph.toml"
    path.write_text(GRAPH.replace("OVERFLOW", "wrap"))
    return path


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    def run(*words: object, code: int = 0) -> str:
        assert main(["run", *map(str, words)]) == code
        return "".join(capsys.readouterr())

    return run


def test_a_sawtooth_wraps_once_a_period(graph: Path, tmp_path: Path, run: Callable[..., str]) -> None:
    wraps = round(1000 * 0.3 / 8)  # 0.3 a tick, in a register from -4 to 4
    assert f'phase: wrapped in {wraps} of its 1,000 ticks, as its overflow = "wrap" says' in run(graph)
    assert json.loads(run(graph, "--json"))["overflows"] == {"phase": wraps, "quantiser": 0}
    run(graph, "--out", tmp_path / "out")
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["overflows"]["phase"] == wraps
    report = (tmp_path / "out" / "report.html").read_text()
    assert "<h2>Overflows</h2>" in report
    assert f'<th>phase</th><td class="number">{wraps}</td>' in report
    assert "<th>quantiser</th>" not in report


@pytest.mark.parametrize("engine", ["python", "compiled"])
def test_blocks_that_wrap_in_other_ticks_have_counts_of_their_own(engine: str, graph: Path) -> None:
    """Two that wrap for the n-th time where they pass 8 n - 4."""
    text = graph.read_text().replace('phase.input"]', 'phase.input", "quantiser.output -> slow.input"]')
    graph.write_text(text + text[text.index("[blocks.phase]") :].replace("phase", "slow").replace("100", "70"))
    counts = proofmass.simulate(graph, engine=engine).overflows
    assert (counts["phase"], counts["slow"]) == (int((0.3 * 1000 + 4.0) / 8.0), int((0.21 * 1000 + 4.0) / 8.0))


def test_without_overflows_there_is_nothing_to_tell(graph: Path, tmp_path: Path, run: Callable[..., str]) -> None:
    assert "did not fit" not in run(graph, "--set", "phase.gain=1")
    run(graph, "--set", "phase.gain=1", "--out", tmp_path / "out")
    assert "<h2>Overflows</h2>" not in (tmp_path / "out" / "report.html").read_text()


def test_a_refusal_ends_the_command_with_3(graph: Path, run: Callable[..., str]) -> None:
    text = run(graph, "--set", "phase.overflow=refuse", code=3)
    assert "phase.update: failed in tick 13" in text
    assert "does not fit Fixed(20, 17), which holds -4 to 3.999992371" in text
