"""Loops of a graph: read, written, checked, kept in subgraphs."""

from typing import Any

import pytest

from proofmass.blocks import Gain, ShiftRegister, UnitDelay
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.loops import Loop
from tests.by_hand.graph_schema import VALIDATOR

TEXT = """\
rate = "1 kHz"
wires = ["delay.output -> gain.input", "gain.output -> delay.input"]
probes = ["gain.output"]
[loops.main]
open_at = "gain.output"
gain_margin = "6 dB"
phase_margin = "0.5 rad"
delay_margin = "100 us"
sensitivity_peak = 3
[blocks.delay]
kind = "UnitDelay"
[blocks.gain]
kind = "Gain"
gain = -0.5
"""


def test_a_loop_with_requirements() -> None:
    graph = read_graph_text(TEXT)
    loop = graph.loops["main"]
    assert loop.open_at == "gain.output"
    assert loop.requirements == {
        "gain_margin": 6.0,
        "phase_margin": pytest.approx(28.64788975654116),
        "delay_margin": 1e-4,
        "sensitivity_peak": 3.0,
    }
    assert check(graph) == []
    assert read_graph_text(write_graph(graph)) == graph
    assert VALIDATOR.is_valid(_table(TEXT))


def _table(text: str) -> Any:
    import tomllib

    return tomllib.loads(text)


def test_the_same_from_python() -> None:
    blocks: dict[str, Block] = {"delay": UnitDelay(), "gain": Gain(gain=-0.5)}
    wires = ["delay.output -> gain.input", "gain.output -> delay.input"]
    graph = Graph(name="", rate=1000, blocks=blocks, wires=wires, loops={"main": {"open_at": "gain.output"}})
    assert graph.loops == {"main": Loop(open_at="gain.output")}
    assert check(graph)[0].note
    given = Graph(name="", rate=1000, blocks=blocks, wires=wires, loops={"main": Loop(open_at="gain.output")})
    assert given == graph


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('open_at = "gain.output"', "", "model.toml:4: loops.main: has no open_at"),
        ('open_at = "gain.output"', "open_at = 5", "model.toml:5: loops.main.open_at: not an output"),
        ("gain_margin", "gain_margn", "did you mean gain_margin?"),
        ('"6 dB"', '"6 V"', "model.toml:6: loops.main.gain_margin: not a ratio in decibels"),
        ('"6 dB"', "true", "must be a number"),
        ('"6 dB"', "-1", "must be finite and not negative"),
        ('"6 dB"', '"1e999 dB"', "must be finite and not negative"),
        ('"100 us"', '"100 V"', "model.toml:8: loops.main.delay_margin"),
        ("[loops.main]", "[loops.Main]", "not a name"),
        ('[loops.main]\nopen_at = "gain.output"', 'loops.main = "gain.output"\n[x]', "loops.main: must be a table"),
        ('[loops.main]\nopen_at = "gain.output"', 'loops = ["gain.output"]\n[x]', "loops: must be a table"),
    ],
)
def test_what_is_wrong_has_its_place(old: str, new: str, expected: str) -> None:
    with pytest.raises(ModelError) as caught:
        read_graph_text(TEXT.replace(old, new), "model.toml")
    assert expected in str(caught.value)


@pytest.mark.parametrize(
    ("signal", "expected"),
    [
        ("gain.outptu", "did you mean output?"),
        ("gian.output", "did you mean gain?"),
        ("gain.input", "is an input, not an output"),
    ],
)
def test_a_loop_opens_at_an_output(signal: str, expected: str) -> None:
    (problem,) = check(read_graph_text(TEXT.replace('open_at = "gain.output"', f'open_at = "{signal}"'), "model.toml"))
    assert (problem.file, problem.line, problem.key) == ("model.toml", 5, "loops.main.open_at")
    assert expected in str(problem)


def test_a_loop_opens_at_one_number() -> None:
    graph = Graph(name="", rate=1000, blocks={"bits": ShiftRegister()}, loops={"main": {"open_at": "bits.bit"}})
    assert "bits.bit is true or false" in str(check(graph)[0])


def test_loops_of_subgraphs_bear_their_paths_and_go_through_exports() -> None:
    part = read_graph_text(TEXT)
    outer = Graph(
        name="two", blocks={"x_axis": part, "z_axis": part}, loops={"own": {"open_at": "x_axis.delay.output"}}
    )
    flat = flatten(outer)
    assert {name: loop.open_at for name, loop in flat.loops.items()} == {
        "own": "x_axis.delay.output",
        "x_axis.main": "x_axis.gain.output",
        "z_axis.main": "z_axis.gain.output",
    }
    assert flat.loops["z_axis.main"].gain_margin == 6.0
    assert read_graph_text(write_graph(outer)) == outer
    wrong = read_graph_text(TEXT.replace('"gain.output"\ngain', '"gain.outpt"\ngain'), "part.toml")
    found = [problem for problem in check(Graph(name="two", blocks={"x_axis": wrong})) if not problem.note]
    assert [(problem.file, problem.line, problem.key) for problem in found] == [
        ("part.toml", 5, "x_axis.loops.main.open_at")
    ]
