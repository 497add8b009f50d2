"""The order in which blocks, wires and probes are declared changes no bit: not of the rows, not of the loop."""

import random
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.flatten import flatten
from proofmass.runner.planning.plan import plan
from proofmass.runner.program.tick import write_tick
from proofmass.runner.run.simulate import simulate
from proofmass.runner.targets.llvm_text import llvm_text
from tests.by_hand.amounts import amounts
from tests.by_hand.graph_texts import COMPILED, WALKED
from tests.by_hand.orders import shuffled


@pytest.mark.exhaustive(but=4)
@pytest.mark.parametrize("permutations", amounts(4, 50))
@pytest.mark.parametrize("path", WALKED)
def test_permutations_of_every_example_graph(path: Path, permutations: int) -> None:
    graph = flatten(read_graph(path)).as_graph()
    every_output = [f"{name}.{port}" for name, block in graph.blocks.items() for port in type(block).outputs]
    graph = replace(graph, probes=every_output)
    planned = plan(graph)
    source = llvm_text(write_tick(planned).program)
    expected = simulate(graph, samples=3000, engine="compiled") if path.stem in COMPILED else None
    dice = random.Random(path.stem)
    for number in range(permutations):
        other = shuffled(graph, dice)
        other_plan = plan(other)
        assert replace(other_plan, graph=planned.graph) == planned  # the graph has its probes in another order
        assert llvm_text(write_tick(other_plan).program) == source
        if expected is None or number >= 5:  # of the same loop with the same numbers
            continue
        result = simulate(other, samples=3000, engine="compiled")
        for name in every_output:
            assert np.array_equal(result[name].values, expected[name].values), name


@pytest.mark.exhaustive(but=5)
@pytest.mark.parametrize("samples", amounts(60, 400))
@pytest.mark.parametrize("path", WALKED)
def test_permutations_in_plain_python(path: Path, samples: int) -> None:
    graph = flatten(read_graph(path)).as_graph()
    expected = simulate(graph, samples=samples, engine="python")
    dice = random.Random(path.stem)
    for _ in range(5):
        result = simulate(shuffled(graph, dice), samples=samples, engine="python")
        for name in expected:
            assert np.array_equal(result[name].values, expected[name].values), name
