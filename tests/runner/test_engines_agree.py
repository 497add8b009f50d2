"""The main test of the project: plain Python and the compiled loop give the same bits."""

import random
from pathlib import Path

import numpy as np
import pytest

from proofmass.blocks.catalog import all_blocks
from proofmass.graphs.graph import Graph
from proofmass.graphs.toml_reader import read_graph
from proofmass.runner.simulate import simulate
from tests.around import graph_around, random_block

LIBRARY = sorted((Path(__file__).parents[2] / "graphs" / "library").glob("*.toml"))
SAMPLES = 10_000


def assert_same_bits(graph: Graph, samples: int) -> None:
    """Every probe, bit for bit, in both engines."""
    python = simulate(graph, samples=samples, engine="python")
    compiled = simulate(graph, samples=samples, engine="compiled")
    assert list(python) == list(compiled)
    for name in python:
        left, right = python[name].values, compiled[name].values
        assert left.dtype == right.dtype
        assert left.shape == right.shape
        different = np.flatnonzero((_bits(left) != _bits(right)).any(axis=1))
        assert not len(different), f"{name} differs in {len(different)} rows, first {different[0]}"


def _bits(values: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
    """One row of integers per row: -0.0 is not 0.0, and a NaN is itself."""
    rows = values.reshape(len(values), -1)
    return rows.view(np.uint64) if values.dtype == np.float64 else rows


@pytest.mark.parametrize("kind", all_blocks().values(), ids=lambda kind: kind.__name__)
def test_every_block_with_five_random_parameter_sets(kind: type, tmp_path: Path) -> None:
    dice = random.Random(kind.__name__)
    for _ in range(5):
        assert_same_bits(graph_around(random_block(kind, dice, tmp_path), tmp_path), SAMPLES)


@pytest.mark.parametrize("path", LIBRARY, ids=lambda path: path.stem)
def test_every_example_graph(path: Path) -> None:
    assert_same_bits(read_graph(path), SAMPLES)
