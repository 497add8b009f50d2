"""Vectors of signals, in order, in a graph with what takes them apart again."""

import pytest

from proofmass.blocks import Constant, VectorElement, VectorJoin
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.functions import drive


@pytest.mark.parametrize("size", [1, 2, 4])
def test_components_in_order(size: int) -> None:
    row = {"first": 1.5, "second": -2.0, "third": 3.0, "fourth": 4.25}
    (answer,) = drive(VectorJoin(size=size), [row], 1.0)
    assert list(answer["output"]) == [1.5, -2.0, 3.0, 4.25][:size]


@pytest.mark.parametrize("engine", ["python", "compiled"])
def test_joined_and_taken_apart(engine: str) -> None:
    blocks: dict[str, Block] = {
        "a": Constant(value=1.0, unit="T"),
        "b": Constant(value=-7.0, unit="T"),
        "join": VectorJoin(size=2, unit="T"),
        "second": VectorElement(size=2, index=1, unit="T"),
    }
    wires = ["a.output -> join.first", "b.output -> join.second", "join.output -> second.vector"]
    graph = Graph(name="vector", rate=10, blocks=blocks, wires=wires, probes=["second.output"])
    assert simulate(graph, samples=3, engine=engine)["second.output"].values.tolist() == [-7.0] * 3  # type: ignore[arg-type]
