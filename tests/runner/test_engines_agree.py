"""The main test of the project: plain Python and the compiled loop give the same bits."""

import random
from pathlib import Path

import numpy as np
import pytest

from proofmass.blocks.catalog import all_blocks
from proofmass.blocks.declare import Block
from proofmass.graphs.graph import Graph
from proofmass.graphs.toml_reader import read_graph
from proofmass.runner.result import Result
from proofmass.runner.simulate import EngineName, RunError, simulate
from tests.around import graph_around, random_block
from tests.graph_texts import ALONE

SAMPLES = 10_000


def assert_same_bits(graph: Graph, samples: int) -> None:
    """Every probe, bit for bit, in both engines; a run that fails fails with the same words."""
    python, compiled = run(graph, samples, "python"), run(graph, samples, "compiled")
    if isinstance(python, str) or isinstance(compiled, str):
        assert python == compiled
        assert "OverflowError" in python
        return
    assert list(python) == list(compiled)
    assert python.overflows == compiled.overflows
    for name in python:
        left, right = python[name].values, compiled[name].values
        assert left.dtype == right.dtype
        assert left.shape == right.shape
        different = np.flatnonzero((_bits(left) != _bits(right)).any(axis=1))
        assert not len(different), f"{name} differs in {len(different)} rows, first {different[0]}"


def run(graph: Graph, samples: int, engine: EngineName) -> Result | str:
    """The result, or why a cast refused."""
    try:
        return simulate(graph, samples=samples, engine=engine)
    except RunError as error:
        return str(error)


def _bits(values: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
    """One row of integers per row: -0.0 is not 0.0, and a NaN is itself."""
    rows = values.reshape(len(values), -1)
    return rows.view(np.uint64) if values.dtype == np.float64 else rows


@pytest.mark.parametrize("kind", all_blocks().values(), ids=lambda kind: kind.__name__)
def test_every_block_with_random_parameter_sets(kind: type[Block], tmp_path: Path) -> None:
    dice = random.Random(kind.__name__)
    # Rounding and overflow are part of the code of a digital block: each set compiles anew, to straight lines.
    sets, samples = (3, SAMPLES // 5) if kind.digital() else (5, SAMPLES)
    for _ in range(sets):
        assert_same_bits(graph_around(random_block(kind, dice, tmp_path), tmp_path), samples)


@pytest.mark.parametrize("path", ALONE, ids=lambda path: path.stem)
def test_every_example_graph(path: Path) -> None:
    assert_same_bits(read_graph(path), SAMPLES)
