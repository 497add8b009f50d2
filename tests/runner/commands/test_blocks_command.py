"""Blocks by family, found by words, and each with an example that runs."""

import json
from pathlib import Path

import pytest

from proofmass.blocks.declaration.catalog import all_blocks, family_of
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.example import example_of
from proofmass.runner.command_line import main
from proofmass.runner.run.simulate import simulate

KINDS = all_blocks()


def said(capsys: pytest.CaptureFixture[str], *words: str, code: int = 0) -> str:
    assert main(["blocks", *words]) == code
    shown = capsys.readouterr()
    return shown.out + shown.err


@pytest.mark.friendly(11, "every kind stands under its family")
def test_every_kind_stands_under_its_family(capsys: pytest.CaptureFixture[str]) -> None:
    family, listed = "", dict[str, str]()
    for line in said(capsys).splitlines():
        if line.startswith("  "):
            listed[line.split()[0]] = family
        elif line:
            family = line.partition(":")[0]
    assert listed == {name: family_of(kind) for name, kind in KINDS.items()}


@pytest.mark.parametrize(
    ("words", "kinds"),
    [
        ("phase detector", {"PhaseMixer", "PhaseFrequencyDetector", "XorPhaseDetector"}),
        ("MIXER", {"Product", "PhaseMixer"}),
        ("butterworth", {"Butterworth"}),
        ("saturation", {"Saturation"}),
        ("summing junction", {"Sum"}),
    ],
)
@pytest.mark.friendly(11, "blocks are found by words for their purpose")
def test_words_that_describe(words: str, kinds: set[str], capsys: pytest.CaptureFixture[str]) -> None:
    shown = json.loads(said(capsys, "--find", words, "--json"))
    assert kinds <= {one["kind"] for one in shown}
    assert all(all(word in json.dumps(one).lower() for word in words.lower().split()) for one in shown)


def test_words_that_describe_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    assert "no block is described by: flux capacitor" in said(capsys, "--find", "flux capacitor", code=1)
    assert "here that is RateLimiter" in said(capsys, "--find", "SlewRateLimiter", code=1)
    assert "--example needs a kind" in said(capsys, "--example", code=2)


def test_an_example_is_a_graph_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "example.toml"
    path.write_text(said(capsys, "PID", "--example"))
    assert main(["run", str(path), "--quiet"]) == 0


@pytest.mark.exhaustive(but=90)
@pytest.mark.parametrize("name", KINDS)
def test_examples_run(name: str) -> None:
    """A few ticks in plain Python; what needs a recording says so, and nothing else is missing."""
    graph = example_of(KINDS[name])
    problems = [problem for problem in check(graph) if not problem.note]
    if any(buffer.recorded for buffer in KINDS[name].buffers.values()):
        assert [problem.key for problem in problems] in ([], ["blocks.block.file"])
        return
    assert problems == []
    again = read_graph_text(write_graph(graph), "example.toml")
    assert again.blocks == graph.blocks
    result = simulate(again, samples=4, engine="python")
    assert {signal.partition(".")[2] for signal in result} == set(KINDS[name].outputs)
