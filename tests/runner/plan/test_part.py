"""A part of a plan: its blocks do what they do in the whole, to the last bit."""

from dataclasses import replace

import pytest

from proofmass import Graph, read_graph
from proofmass.blocks import Gain, LowPass, Sum, WhiteNoise
from proofmass.blocks.declaration.declare import Block
from proofmass.runner.plan.memory import start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.engines import make_engine

SEED = 5


def alike(whole: Plan, *names: str, ticks: int = 60) -> set[str]:
    """Hold states and wires of a part, by machine code, against those of the whole; returns the blocks of the part."""
    part = whole.part({*names})
    whole = replace(whole, probes=())
    begin = start(whole)
    runs = [make_engine(of, name, SEED, 0, begin, ticks) for of, name in ((whole, "python"), (part, "compiled"))]
    assert all(run.advance(ticks, ()) for run in runs)
    first, second = (run.memory() for run in runs)
    assert second.wires.keys() == {node for node in first.wires if node[0] in part.blocks}
    assert second.wires == {node: first.wires[node] for node in second.wires}
    assert {name: second.states[name] for name in part.blocks} == {name: first.states[name] for name in part.blocks}
    return {*part.blocks}


@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize("name", ["x", "y", "z"])
def test_an_axis_draws_what_it_draws_among_three(name: str) -> None:
    """The noise of a block has the shortest name that no other of the whole shares: alone it would have another."""
    whole = plan(read_graph("library:imu_3dof"))
    blocks = alike(whole, f"{name}.damping")
    assert 2 * len(blocks) < len(whole.blocks)
    assert {block.partition(".")[0] for block in blocks if "." in block} == {name}


def test_a_part_has_what_moves_with_its_blocks_and_what_drives_that() -> None:
    """Two continuous filters in a row are one group, whose second has an input of its own."""
    blocks = {"noise": WhiteNoise(), "other": WhiteNoise(), "apart": WhiteNoise(), "late": Gain(gain=2.0)}
    blocks |= {"first": LowPass(corner_frequency=10.0), "sum": Sum(), "second": LowPass(corner_frequency=20.0)}
    wires = ["noise.output -> first.input", "first.output -> sum.first", "other.output -> sum.second"]
    wires += ["sum.output -> second.input", "apart.output -> late.input"]
    whole = plan(Graph(name="", rate="1 kHz", blocks=blocks, wires=wires))
    assert alike(whole, "first") == {"noise", "first", "sum", "other", "second"}
    assert alike(whole, "late") == {"apart", "late"}


def test_a_part_has_the_loops_without_delay_of_its_blocks() -> None:
    """Two loops, sum = noise + gain sum; the part has the one, and solves it."""
    blocks: dict[str, Block] = {"noise": WhiteNoise()}
    wires = list[str]()
    for name, gain in (("one", 0.5), ("two", -0.75)):
        blocks |= {f"{name}_sum": Sum(), f"{name}_gain": Gain(gain=gain)}
        wires += [f"noise.output -> {name}_sum.first", f"{name}_gain.output -> {name}_sum.second"]
        wires += [f"{name}_sum.output -> {name}_gain.input"]
    graph = Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, integration={"algebraic_loops": "newton"})
    whole = plan(graph)
    assert len(whole.schedule.loops) == 2
    assert alike(whole, "two_sum") == {"noise", "two_sum", "two_gain"}
    assert len(whole.part({"two_sum"}).schedule.loops) == 1
