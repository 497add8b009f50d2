"""Loops found in wires, and where each can be opened."""

from proofmass.blocks import Gain, LowPass, Sum, UnitDelay
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.find_loops import LoopGroup, find_loops
from proofmass.runner.planning.plan import plan
from tests.by_hand.crossing_loops import BLOCKS, WIRES


def found(blocks: dict[str, Block], wires: list[str], **more: object) -> list[LoopGroup]:
    return find_loops(plan(Graph(name="loops", rate=1000, blocks=blocks, wires=wires, **more)))  # type: ignore[arg-type]


def test_the_loop_of_the_accelerometer_opens_at_each_of_its_outputs() -> None:
    (loop,) = find_loops(plan(read_graph(library_file("closed_loop_accelerometer.toml"))))
    assert len(loop.ports) == 9
    assert loop.open_at == loop.ports


def test_a_graph_without_a_loop() -> None:
    assert find_loops(plan(read_graph(library_file("pn_self_test_minimal.toml")))) == []
    assert found({"a": UnitDelay(), "b": Gain()}, ["a.output -> b.input", "b.output -> a.input"]) != []


def test_two_loops_apart_are_two() -> None:
    blocks: dict[str, Block] = {"a": UnitDelay(), "b": UnitDelay()}
    loops = found(blocks, ["a.output -> a.input", "b.output -> b.input"])
    assert [loop.open_at for loop in loops] == [("a.output",), ("b.output",)]


def test_nested_loops_open_at_what_they_share() -> None:
    """An inner and an outer loop through one delay: only the wire that both go through opens them."""
    blocks: dict[str, Block] = {"sum": Sum(), "delay": UnitDelay(), "outer": UnitDelay(), "inner": Gain()}
    wires = [
        "sum.output -> delay.input",
        "delay.output -> inner.input",
        "delay.output -> outer.input",
        "inner.output -> sum.first",
        "outer.output -> sum.second",
    ]
    (loop,) = found(blocks, wires)
    assert len(loop.ports) == 4
    assert loop.open_at == ("delay.output", "sum.output")


def test_loops_that_cross_have_no_such_wire() -> None:
    (loop,) = found(BLOCKS, WIRES)
    assert loop.open_at == ()


def test_slow_wires_come_first_and_continuous_ones_are_not_cut_inside() -> None:
    blocks: dict[str, Block] = {"first": LowPass(), "second": LowPass(), "fast": UnitDelay(), "slow": UnitDelay()}
    wires = [
        "first.output -> second.input",
        "second.output -> fast.input",
        "fast.output -> slow.input",
        "slow.output -> first.input",
    ]
    (loop,) = found(blocks, wires, rates={"slow": 100})
    assert loop.open_at == ("slow.output", "fast.output", "second.output")
