"""The compiled loop tick by tick, against counting."""

from dataclasses import replace

from proofmass.blocks import Constant, DiscreteIntegrator
from proofmass.graphs.model.build import Graph
from proofmass.runner.plan.keys import StateField
from proofmass.runner.planning.plan import plan
from proofmass.runner.targets.native import CompiledLoop


def test_wires_and_states_of_each_tick_up_to_one_that_is_not_run() -> None:
    blocks = {"one": Constant(value=1.0), "count": DiscreteIntegrator(gain=8.0)}
    wires = ["one.output -> count.input"]
    probes = ("count.output", "one.output")
    graph = Graph(name="", rate="8 Hz", samples=10, blocks=blocks, wires=wires, probes=probes)
    loop = CompiledLoop(plan(graph), seed=0)
    nodes = [("count", "output"), ("one", "output")]
    assert loop.wires(nodes, 3).tolist() == [[0.0, 1.0], [1.0, 1.0], [2.0, 1.0]]
    assert (loop.tick, loop.memory().tick) == (3, 3)
    assert loop.wires(nodes, 3).shape == (0, 2)
    assert loop.wires(nodes[:1], 5).tolist() == [[3.0], [4.0]]
    (field,) = loop.memory().states["count"]._fields  # type: ignore[union-attr]
    lone = CompiledLoop(plan(replace(graph, probes=())), 0, memory=loop.memory())
    assert lone.numbers([StateField("count", field)], 7).tolist() == [[6.0], [7.0]], "after the tick"
    assert lone.tick == 7
