"""Rates of blocks inside parts: exported, set from outside, by formulas, exactly."""

from fractions import Fraction
from pathlib import Path

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.rates import simplest
from proofmass.graphs.studies.build import Study
from proofmass.runner.run.simulate import simulate

PART = """
name = "part"
wires = ["hold.output -> average.input"]
exports = { input = "hold.input", mean = "average.mean", hold_rate = "hold.rate", output_rate = "average.rate" }

[blocks.hold]
kind = "UnitDelay"
rate = "10 kHz"

[blocks.average]
kind = "Decimator"
ratio = 2
rate = "10 kHz"
"""
TOP = """
name = "top"
rate = "= 1 / transit"
samples = 30
wires = ["source.output -> part.input"]
probes = ["part.mean"]

[values]
transit = "5 us"

[blocks.source]
kind = "Ramp"

[blocks.part]
graph = "part.toml"
hold_rate = "= 1 / (2 * transit)"
output_rate = "100 kHz"
"""


@pytest.fixture
def graph(tmp_path: Path) -> Graph:
    (tmp_path / "part.toml").write_text(PART, encoding="utf-8")
    (tmp_path / "top.toml").write_text(TOP, encoding="utf-8")
    return read_graph(tmp_path / "top.toml")


def rates(graph: Graph) -> list[object]:
    flat = flatten(graph)
    return [flat.rate, flat.rates["part.hold"], flat.rates["part.average"]]


def test_an_exported_rate_is_given_by_a_number_or_a_formula(graph: Graph) -> None:
    assert rates(graph) == [200_000, 100_000, 100_000]
    assert not [problem for problem in check(graph) if not problem.note]
    assert simulate(graph, engine="python")["part.mean"].values[-1] > 0.0


def test_it_follows_a_value_and_is_changed_alone(graph: Graph) -> None:
    assert rates(graph.with_parameters({"transit": "10 us"})) == [100_000, 50_000, 100_000]
    assert rates(graph.with_parameters({"part.hold_rate": "20 us"})) == [200_000, 50_000, 100_000]
    assert rates(graph.with_parameters({"part.average.rate": 1000})) == [200_000, 100_000, 1000]
    changed = graph.with_parameters({"part.hold_rate": "= 3 / (4 * transit)"})
    assert rates(changed.with_parameters({"transit": "3 us"})) == [Fraction(1_000_000, 3), 250_000, 100_000]


def test_it_is_written_and_read_again(graph: Graph, tmp_path: Path) -> None:
    (tmp_path / "written.toml").write_text(write_graph(graph), encoding="utf-8")
    again = read_graph(tmp_path / "written.toml")
    assert rates(again.with_parameters({"transit": "10 us"})) == [100_000, 50_000, 100_000]


@pytest.mark.parametrize(
    ("value", "said"),
    [("-3 Hz", "must be above 0 Hz"), ("3 V", "V is"), ("= 3 V", "is V"), ("= transit - 5 us", "must be above zero")],
)
def test_what_is_no_rate_is_refused_with_its_name(graph: Graph, value: str, said: str) -> None:
    with pytest.raises(ModelError, match=said) as caught:
        graph.with_parameters({"part.hold_rate": value})
    assert "part.hold" in str(caught.value)


def test_a_study_does_not_sweep_a_rate(graph: Graph) -> None:
    with pytest.raises(ModelError, match="hold_rate"):
        Study(graph, sweep={"part.hold_rate": ["10 kHz", "20 kHz"]})


def test_a_formula_gives_the_rate_without_its_rounding() -> None:
    assert simplest(1.0 / 5e-6) == 200_000
    assert simplest(1e6 / 3.0) == Fraction(1_000_000, 3)
    assert simplest(48_000.000_000_1) == Fraction("48000.0000001")
    for numerator, denominator in ((9600, 1023), (1, 7), (123_456_789, 1000), (1, 10**9)):
        assert simplest(numerator / denominator) == Fraction(numerator, denominator)


@pytest.mark.defect("S710", before="a block called rate or duration gave its rate to the graph", after="to itself")
@pytest.mark.parametrize("name", ["rate", "duration"])
def test_blocks_that_are_called_as_keys_of_the_graph(tmp_path: Path, name: str) -> None:
    text = TOP.replace("samples = 30", 'duration = "= 32 * transit"').replace("[blocks.part]", f"[blocks.{name}]")
    text = text.replace("part.mean", f"{name}.output").replace("part.input", f"{name}.input")
    text = text.replace('graph = "part.toml"\nhold_rate', 'kind = "Gain"\nrate').replace(
        'output_rate = "100 kHz"\n', ""
    )
    (tmp_path / "top.toml").write_text(text, encoding="utf-8")
    graph = read_graph(tmp_path / "top.toml")
    assert (graph.rate, dict(graph.rates), graph.duration) == (200_000, {name: 100_000}, pytest.approx(160e-6))
    slower = graph.with_parameters({"transit": "10 us"})
    assert (slower.rate, dict(slower.rates), slower.duration) == (100_000, {name: 50_000}, pytest.approx(320e-6))
    alone = graph.with_parameters({f"{name}.rate": "25 kHz"})
    assert (alone.rate, dict(alone.rates), alone.duration) == (200_000, {name: 25_000}, pytest.approx(160e-6))


@pytest.mark.defect("S700", before="a rate whose formula cannot be read had no line", after="its own line")
def test_a_formula_of_a_rate_that_cannot_be_read(tmp_path: Path) -> None:
    text = TOP.replace('kind = "Ramp"', 'kind = "Ramp"\nrate = "= #1"')
    (tmp_path / "part.toml").write_text(PART, encoding="utf-8")
    (tmp_path / "top.toml").write_text(text, encoding="utf-8")
    with pytest.raises(ModelError) as caught:
        read_graph(tmp_path / "top.toml")
    (problem,) = (each for each in caught.value.problems if "cannot be read at" in each.message)
    assert problem.line
    assert text.splitlines()[problem.line - 1] == 'rate = "= #1"'
