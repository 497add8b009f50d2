"""The order in which blocks, wires and probes are declared changes no bit: not of the rows, not of the loop."""

import random
from pathlib import Path

import numpy as np
import pytest

from proofmass.graphs.flatten import flatten
from proofmass.graphs.graph import Graph
from proofmass.graphs.toml_reader import read_graph
from proofmass.runner.generate import generate
from proofmass.runner.plan import plan
from proofmass.runner.simulate import simulate
from tests.graph_texts import ALONE


def shuffled(graph: Graph, dice: random.Random) -> Graph:
    """The same graph, declared in another order."""

    def mixed(things: object) -> list:  # type: ignore[type-arg]
        order = list(things)  # type: ignore[call-overload]
        dice.shuffle(order)
        return order

    return Graph(
        name=graph.name,
        description=graph.description,
        rate=graph.rate,
        duration=graph.duration,
        samples=graph.samples,
        seed=graph.seed,
        blocks=dict(mixed(graph.blocks.items())),
        rates=dict(mixed(graph.rates.items())),
        subgraphs=dict(mixed(graph.subgraphs.items())),
        wires=mixed(graph.wires),
        probes=mixed(graph.probes),
        place=graph.place,
    )


@pytest.mark.parametrize("path", ALONE, ids=lambda path: path.stem)
def test_fifty_permutations_of_every_example_graph(path: Path) -> None:
    graph = read_graph(path)
    every_output = [f"{name}.{port}" for name, block in flatten(graph).blocks.items() for port in block.outputs]
    graph = Graph(
        name=graph.name, rate=graph.rate, seed=graph.seed, blocks=graph.blocks, rates=graph.rates, wires=graph.wires,
        subgraphs=graph.subgraphs, probes=every_output, place=graph.place,
    )  # fmt: skip
    source = generate(plan(graph)).source
    expected = simulate(graph, samples=3000, engine="compiled")
    dice = random.Random(path.stem)
    for _ in range(50):
        other = shuffled(graph, dice)
        assert generate(plan(other)).source == source
        result = simulate(other, samples=3000, engine="compiled")
        for name in every_output:
            assert np.array_equal(result[name].values, expected[name].values), name


@pytest.mark.parametrize("path", ALONE, ids=lambda path: path.stem)
def test_permutations_in_plain_python(path: Path) -> None:
    graph = read_graph(path)
    expected = simulate(graph, samples=400, engine="python")
    dice = random.Random(path.stem)
    for _ in range(5):
        result = simulate(shuffled(graph, dice), samples=400, engine="python")
        for name in expected:
            assert np.array_equal(result[name].values, expected[name].values), name
