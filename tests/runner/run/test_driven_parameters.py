"""A parameter that a wire drives is the parameter set to what the wire holds, bit for bit, whichever it is."""

import random
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from proofmass.blocks import Constant, LowPass, Ramp
from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import unit_of
from proofmass.graphs.model.build import Graph
from proofmass.runner.contract.around import graph_around
from proofmass.runner.contract.drawn import random_block, random_value
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.simulate import simulate

SAMPLES = 150
# Not of blocks with events, which take minutes in plain Python; tests/runner/planning/test_events.py has one.
DRIVABLE = {
    kind: [parameter for parameter in kind.parameters if kind.drivable(parameter)]
    for kind in all_blocks().values()
    if any(map(kind.drivable, kind.parameters)) and not kind.events
}


def bits(graph: Graph, engine: EngineName) -> dict[str, bytes]:
    result = simulate(graph, samples=SAMPLES, engine=engine)
    return {name: np.ascontiguousarray(result[name].values).tobytes() for name in result}


def driven(graph: Graph, parameters: dict[str, list[str]]) -> Graph:
    """The graph with the parameters of blocks at their defaults, and driven by constants of the values they had."""
    blocks, wires = dict(graph.blocks), list(map(str, graph.wires))
    for name, names in parameters.items():
        block = graph.blocks[name]
        for parameter in names:
            source = f"drive_{len(blocks)}"
            blocks[source] = Constant(
                value=getattr(block, parameter), unit=unit_of(block, type(block).parameters[parameter])
            )
            wires.append(f"{source}.output -> {name}.{parameter}")
        blocks[name] = at_default(block, names)
    return replace(graph, blocks=blocks, wires=wires)


def at_default(block: Block, parameters: list[str]) -> Block:
    values = {name: getattr(block, name) for name in type(block).parameters}
    return type(block)(**(values | {name: type(block).parameters[name].default for name in parameters}))


def drawn(kind: type[Block], dice: random.Random, folder: Path) -> Block:
    """A random block none of whose parameters that can be driven is at its default."""
    block = random_block(kind, dice, folder)
    values = {name: getattr(block, name) for name in kind.parameters}
    for name in DRIVABLE[kind]:
        while values[name] == kind.parameters[name].default:
            values[name] = random_value(kind.parameters[name], dice)
    return kind(**values)


@pytest.mark.exhaustive(but=14)
@pytest.mark.parametrize("kind", DRIVABLE, ids=lambda kind: kind.__name__)
def test_each_alone_in_plain_python(kind: type[Block], tmp_path: Path) -> None:
    block = drawn(kind, random.Random(kind.__name__), tmp_path)
    graph = graph_around({"block": block}, tmp_path)
    expected = bits(graph, "python")
    for parameter in DRIVABLE[kind]:
        assert bits(driven(graph, {"block": [parameter]}), "python") == expected, parameter


@pytest.mark.exhaustive
def test_nearly_all_of_these_blocks_have_a_parameter_that_counts_in_these_samples(tmp_path: Path) -> None:
    counting = []
    for kind, names in DRIVABLE.items():
        block = drawn(kind, random.Random(kind.__name__), tmp_path)
        graph = graph_around({"block": block}, tmp_path)
        others = (replace(graph, blocks=dict(graph.blocks) | {"block": at_default(block, [name])}) for name in names)
        expected = bits(graph, "python")
        counting.append(any(bits(other, "python") != expected for other in others))
    assert sum(counting) > 0.9 * len(counting)


@pytest.mark.exhaustive
@pytest.mark.parametrize("first", [0, 1])
def test_all_at_once_compiled(first: int, tmp_path: Path) -> None:
    """Of blocks with constants, which are then computed in the loop."""
    computed = [kind for kind in DRIVABLE if "constants" in kind.functions][first::2]
    dice = random.Random(first)
    tested = {f"block_{n}": drawn(kind, dice, tmp_path) for n, kind in enumerate(computed)}
    graph = graph_around(tested, tmp_path)
    loop = driven(graph, {name: DRIVABLE[type(block)] for name, block in tested.items()})
    expected, found = bits(graph, "python"), bits(loop, "compiled")
    assert [name for name in expected if found[name] != expected[name]] == []


@pytest.mark.parametrize("engine", ["python", "compiled"])
@pytest.mark.parametrize("slope", [0.0, 1.0])
def test_a_parameter_that_moves_between_ticks(slope: float, engine: EngineName) -> None:
    """x' = v (1 - x), y' = w (x u - y), of u = 1 or u = t, on a straight line between ticks.

    Without x, y of t is t - (1 - exp(-w t)) / w; t exp(-v t) makes w / (w - v) (t - 1 / (w - v))
    exp(-v t) + w / (w - v)^2 exp(-w t).
    """
    v, w = 2.0 * np.pi * 20.0, 2.0 * np.pi * 50.0
    source = Ramp(offset=0.0, slope=slope) if slope else Constant(value=1.0)
    graph = Graph(
        name="product",
        rate="1 kHz",
        duration="0.1 s",
        blocks={
            "one": Constant(value=1.0),
            "u": source,
            "x": LowPass(corner_frequency=20.0),
            "y": LowPass(corner_frequency=50.0),
        },
        wires=["one.output -> x.input", "u.output -> y.input", "x.output -> y.gain"],
        probes=["y.output"],
        integration={"sources": "first_order_hold", "accuracy": 1e-10},
    )
    trace = simulate(graph, engine=engine)["y.output"]
    t, apart = trace.times, w - v
    fast, slow = np.exp(-w * t), np.exp(-v * t)
    expected = t - (1.0 - fast) / w - w / apart * (t - 1.0 / apart) * slow - w / apart**2 * fast
    if not slope:
        expected = 1.0 - fast - w / apart * (slow - fast)
    assert trace.values == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())
