"""Loops found in wires, and where each can be opened."""

import math

import pytest

from proofmass import margins
from proofmass.blocks import (
    Comparator,
    Constant,
    DataFlipFlop,
    Difference,
    Gain,
    Integrator,
    LowPass,
    NotGate,
    Sum,
    Switch,
    UnitDelay,
)
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


def lag_in_a_loop() -> Graph:
    """A sampled gain of 5 about x' = 100 (u - x), an integrator with feedback of its own."""
    blocks: dict[str, Block] = {
        "level": Constant(value=1.0), "error": Difference(), "control": Gain(gain=5.0), "held": UnitDelay(),
        "within": Difference(), "plant": Integrator(gain=100.0, output_unit="1"),
    }  # fmt: skip
    wires = ["level.output -> error.first", "plant.output -> error.second", "error.output -> control.input"]
    wires += ["control.output -> held.input", "held.output -> within.first", "plant.output -> within.second"]
    wires += ["within.output -> plant.input"]
    return Graph(name="lag", rate=1000, blocks=blocks, wires=wires)


@pytest.mark.defect("C865", before='"these loops have no output at which they can be opened"', after="both loops")
def test_a_plant_with_feedback_of_its_own_stays_closed() -> None:
    """L is 5 (1 - p) / (z - p) / z with p = exp(-0.1), and 100 / s within; z^2 - p z + c ends at c = 1."""
    outer, inner = find_loops(plan(lag_in_a_loop()))
    assert outer.open_at == ("control.output", "error.output", "held.output")
    assert inner.ports == inner.open_at == ("plant.output", "within.output")
    found = margins(lag_in_a_loop(), "control.output")
    assert found.gain_margin == pytest.approx(1.0 / (5.0 * (1.0 - math.exp(-0.1))), rel=1e-9)
    alone = margins(lag_in_a_loop(), "plant.output")
    assert alone.gain_margin is None
    assert alone.phase_margin == pytest.approx(0.5 * math.pi)


def test_bits_in_a_loop_stay_closed() -> None:
    """A bit that is turned at each rise holds itself; the loop about it opens at its numbers."""
    blocks: dict[str, Block] = {
        "delay": UnitDelay(), "above": Comparator(), "bit": DataFlipFlop(), "other": NotGate(), "choice": Switch(),
    }  # fmt: skip
    wires = ["delay.output -> above.input", "above.on -> bit.clock", "bit.output -> other.input"]
    wires += ["other.output -> bit.data", "bit.output -> choice.choose_first", "delay.output -> choice.first"]
    outer, inner = found(blocks, [*wires, "delay.output -> choice.second", "choice.output -> delay.input"])
    assert (outer.open_at, inner.open_at) == (("choice.output", "delay.output"), ())
