"""Nesting changes no bit: any graph cut into subgraphs at random gives what it gives in one piece, in both engines.

Noise too: its stream follows from the shortest end of the block's path that no other block shares.
"""

import random
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from proofmass.blocks import Constant, Gain, MassSpringDamper, WhiteNoise
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph, read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.flatten import flatten
from proofmass.runner.run.simulate import simulate
from tests.by_hand.amounts import amounts
from tests.by_hand.graph_texts import COMPILED, WALKED
from tests.by_hand.parts import cut

Engine = Literal["python", "compiled"]
ENGINES: tuple[Engine, ...] = ("python", "compiled")


def bits(graph: Graph, engine: Engine, ticks: int = 2000) -> list[bytes]:
    result = simulate(graph, samples=ticks, engine=engine)
    return [np.ascontiguousarray(result[probe.signal].values).tobytes() for probe in graph.probes]


def leaves(graph: Graph) -> Counter[tuple[str, Block]]:
    """All blocks by their last names, wherever they lie."""
    return Counter((name.rpartition(".")[2], block) for name, block in flatten(graph).blocks.items())


@pytest.mark.exhaustive(but=4)
@pytest.mark.parametrize("ticks", amounts(100, 2000))
@pytest.mark.parametrize("path", WALKED)
def test_the_library_cut_into_subgraphs_at_random(path: Path, ticks: int) -> None:
    graph = read_graph(path)
    whole = bits(graph, "python", ticks)
    dice = random.Random(path.stem)
    engines: tuple[Engine, ...] = ("python", "compiled" if path.stem in COMPILED else "python")
    for depth, engine in zip((2, 5), engines, strict=True):
        nested = graph
        for number in range(depth):
            nested = cut(nested, dice, number)
        assert nested.subgraphs
        assert leaves(nested) == leaves(graph)
        assert [p for p in check(nested) if not p.note] == []
        assert bits(nested, engine, ticks) == whole
        assert read_graph_text(write_graph(nested), folder=graph.place.folder) == nested


def test_continuous_blocks_that_are_integrated_together_may_lie_in_different_subgraphs() -> None:
    """The terms of their sums are added in the order of their last names, wherever they lie."""
    masses = {name: MassSpringDamper(mass=m, damping=1e-3) for name, m in (("b", 1e-7), ("a", 3e-7), ("c", 7e-8))}
    spring = {"push": Constant(value=1e-6, unit="N")}
    blocks: dict[str, Block] = {**masses, **spring}
    wires = ["push.output -> a.force"]
    for left, right in (("a", "b"), ("b", "c")):
        blocks[f"from_{left}"] = Gain(gain=31.7, input_unit="m", output_unit="N")
        wires += [f"{left}.displacement -> from_{left}.input", f"from_{left}.output -> {right}.force"]
    probes = [f"{name}.displacement" for name in masses]
    graph = Graph(name="", rate=10_000, blocks=blocks, wires=wires, probes=probes)
    whole = bits(graph, "python")
    for seed, engine in enumerate(2 * ENGINES[:1] + ENGINES):
        dice = random.Random(seed)
        assert bits(cut(cut(graph, dice, 0), dice, 1), engine) == whole


def test_noise_of_parts_of_a_kind_differs_and_stays_when_they_are_nested() -> None:
    channel = Graph(name="", blocks={"noise": WhiteNoise()}, exports={"output": "noise.output"})
    pair = Graph(name="", rate=100, blocks={"a": channel, "b": channel, "one": WhiteNoise()}, seed=4)
    inner = replace(pair, rate=None, exports={n: f"{n}.output" for n in ("a", "b", "one")})
    outer = Graph(name="", rate=100, blocks={"both": inner}, seed=4)
    flat, nested = (
        simulate(
            replace(graph, probes=[prefix + signal for signal in ("a.output", "b.output", "one.output")]), samples=50
        )
        for graph, prefix in ((pair, ""), (outer, "both."))
    )
    traces = [flat[signal].values.tobytes() for signal in ("a.output", "b.output", "one.output")]
    assert len(set(traces)) == 3
    assert traces == [nested[f"both.{signal}"].values.tobytes() for signal in ("a.output", "b.output", "one.output")]
