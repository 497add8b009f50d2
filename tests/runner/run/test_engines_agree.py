"""The main test of the project: plain Python and the compiled loop give the same bits."""

import random
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from proofmass.blocks import DiscreteMassSpringDamper
from proofmass.blocks.arithmetic.fixed_point import FixedValue
from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.integration import Integration
from proofmass.runner.contract.around import graph_around
from proofmass.runner.contract.drawn import random_block
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import RunError, simulate
from tests.by_hand.amounts import amounts
from tests.by_hand.graph_texts import WALKED

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


KINDS = all_blocks()
FIXED_POINT = [
    kind
    for kind in KINDS.values()
    if any(port.dtype is FixedValue for port in (*kind.inputs.values(), *kind.outputs.values())) or kind.has_formats()
]
TOGETHER = 8  # blocks in a loop: that is compiled sooner than a loop each
STEPPED = [kind for kind in KINDS.values() if kind.continuous() and not kind.linear]
APART = [*FIXED_POINT, *STEPPED, DiscreteMassSpringDamper]
OTHERS = [name for name, kind in KINDS.items() if kind not in APART]
GROUPS = [OTHERS[first : first + TOGETHER] for first in range(0, len(OTHERS), TOGETHER)]


@pytest.mark.exhaustive
def test_a_resonator_of_integrators_with_five_random_parameter_sets(tmp_path: Path) -> None:
    """At a rate at which it is stable."""
    dice = random.Random(7)
    for _ in range(5):
        graph = graph_around({"block": random_block(DiscreteMassSpringDamper, dice, tmp_path)}, tmp_path)
        assert_same_bits(replace(graph, rate=Fraction(1_000_000)), SAMPLES)


@pytest.mark.exhaustive(but=2)
@pytest.mark.parametrize("samples", amounts(SAMPLES // 25, SAMPLES))
@pytest.mark.parametrize("group", GROUPS, ids=",".join)
def test_every_block_with_random_parameter_sets(group: list[str], samples: int, tmp_path: Path) -> None:
    """Five sets of all samples, two of a part of them."""
    dice = {name: random.Random(name) for name in group}
    for _ in range(5 if samples == SAMPLES else 2):
        tested = {name.lower(): random_block(KINDS[name], dice[name], tmp_path) for name in group}
        assert_same_bits(graph_around(tested, tmp_path), samples)


@pytest.mark.exhaustive(but=6)
@pytest.mark.parametrize("sets", amounts(1, 3))
@pytest.mark.parametrize("kind", FIXED_POINT, ids=lambda kind: kind.__name__)
def test_every_block_in_fixed_point_with_random_parameter_sets(kind: type[Block], sets: int, tmp_path: Path) -> None:
    """Rounding and overflow are part of its code: each set compiles anew, to straight lines."""
    dice = random.Random(kind.__name__)
    for _ in range(sets):
        samples = SAMPLES // 25 if sets == 1 else SAMPLES // 5
        assert_same_bits(graph_around({"block": random_block(kind, dice, tmp_path)}, tmp_path), samples)


@pytest.mark.exhaustive("MassBetweenStops")
@pytest.mark.parametrize("kind", STEPPED, ids=lambda kind: kind.__name__)
def test_every_stepped_block_with_two_random_parameter_sets(kind: type[Block], tmp_path: Path) -> None:
    """A tick is many steps, and an event many more: plain Python takes milliseconds for each."""
    dice = random.Random(kind.__name__)
    steps = Integration(method="runge_kutta_4", substeps=4)
    for _ in range(2):
        graph = graph_around({"block": random_block(kind, dice, tmp_path)}, tmp_path)
        assert_same_bits(replace(graph, integration=steps), SAMPLES // 40)


@pytest.mark.exhaustive(but=5)
@pytest.mark.parametrize("samples", amounts(400, SAMPLES))
@pytest.mark.parametrize("path", WALKED)
def test_every_example_graph(path: Path, samples: int) -> None:
    """A sample is longer than a period of 1023 chips."""
    graph = read_graph(path)
    stepped = any(not solver.exact for solver in plan(graph).solvers)
    assert_same_bits(graph, samples // 20 if stepped else samples)
