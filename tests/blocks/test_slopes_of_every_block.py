"""What each block does in whole ticks, memory and groups too: machine code, plain Python and differences of runs agree.

`test_dual_blocks` holds functions of blocks alone.
"""

import random
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from proofmass import Graph
from proofmass.blocks import Constant, Sum
from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Endpoint, split
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.period_map import PeriodMap, period_map
from proofmass.runner.analysis.linearisation.rings import Entry
from proofmass.runner.analysis.linearisation.seeds import NO_RINGS, held_in, place_of, put
from proofmass.runner.contract.around import graph_around
from proofmass.runner.contract.drawn import random_block
from proofmass.runner.derivatives.dual_noise import rounding_blocks
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan, varied

BLOCK = "tested"
TICKS = 0, 40, 173
STEPS = 1e-3, 1e-5, 1e-7  # of a number's size
REST = "rest"  # what a compensated sum has lost: rounding, which has no slope
ROUNDINGS = 1e-14  # of what a run comes to
SAMPLE = "PID", "SigmaDeltaModulator", "CoriolisForce"
AT_A_CORNER = {  # where a run stands at a tick that is looked at, and a difference of runs has no limit
    "FeedbackGainEstimator": "its denominator is zero until it is known",
    "Fluxgate": "its core is saturated, and what is left is rounding",
    "ForwardGainEstimator": "its denominator is zero until it is known",
    "MassBetweenStops": "the mass is held, and let go within the tick",
    "MedianFilter": "its first values are all zero",
    "ToneMeter": "its amplitude is the root of a sum of squares that is nearly zero",
}
UNROUNDED = {
    "FixedSigmaDeltaModulator",
    "MashModulator",
    "SigmaDeltaModulator",
}  # plain Python goes on unrounded levels
Given = tuple[Plan, list[Endpoint], list[Endpoint]]


def around(block: Block, folder: Path, scale: float) -> Given:
    """Return a plan with sources at all inputs, what is added at those of numbers, and the outputs of numbers."""
    graph, kind = graph_around({BLOCK: block}, folder, False, scale), type(block)
    blocks, wires, inputs = dict(graph.blocks), list[str](), list[Endpoint]()
    for wire in graph.wires:
        owner, port = split(wire.target)
        if owner != BLOCK or kind.inputs[port].dtype is not float or kind.inputs[port].shape:
            wires.append(f"{wire.source} -> {wire.target}")
            continue
        name, unit = f"in_{len(inputs)}", unit_of(block, kind.inputs[port])
        blocks |= {name: Sum(unit=unit), f"more_{name}": Constant(value=0.0, unit=unit)}
        wires += [f"{wire.source} -> {name}.first", f"more_{name}.output -> {name}.second"]
        wires.append(f"{name}.output -> {wire.target}")
        inputs.append((name, "output"))
    outputs = [(BLOCK, name) for name, port in kind.outputs.items() if port.is_number and port.dtype is not bool]
    made = Graph(name="", rate=10_000, blocks=blocks, wires=wires, seed=7, place=graph.place)
    return plan(made).without_noise, inputs, outputs


def cases(name: str, folder: Path) -> list[Given]:
    """Return the block by default and with parameters drawn by chance, where it has numbers at both ends."""
    kind, dice = all_blocks()[name], random.Random(name)
    recorded = any(buffer.recorded for buffer in kind.buffers.values())
    blocks = [random_block(kind, dice, folder) if recorded else kind(), random_block(kind, dice, folder)]
    given = [around(block, folder, 0.1**number) for number, block in enumerate(blocks)]
    return [each for each in given if each[1] and each[2]]


def apart(given: Given, whole: PeriodMap, memory: Memory) -> dict[str, float]:
    """Return how far slopes of a map are from differences of runs of one period, of their size, by what is moved."""
    planned, inputs, outputs = given
    last = memory.tick + round(whole.period / planned.period)
    kept = [n for n, entry in enumerate(whole.states) if entry[1] != REST]
    rows = [*kept]
    rows += [whole.order + max(i for i, entry in enumerate(whole.outputs) if entry[:2] == node) for node in outputs]

    def after(of: Plan, begin: Memory) -> Array:
        end = Course(of).from_memory(begin).to(last)
        held = [float(held_in(end, whole.states[n], NO_RINGS)) for n in kept]
        return np.array(held + [float(end.wires[node]) for node in outputs])

    def by_state(entry: Entry) -> Callable[[float], Array]:
        def moved(by: float) -> Array:
            begin = memory.copy()
            put(begin, place_of(begin, entry, NO_RINGS), held_in(memory, entry, NO_RINGS) + by)
            return after(planned, begin)

        return moved

    def by_input(name: str) -> Callable[[float], Array]:
        more: Any = planned.blocks[f"more_{name}"]
        return lambda by: after(varied(planned, {f"more_{name}": replace(more, value=by)}), memory.copy())

    base, found = np.abs(after(planned, memory.copy())) + 1e-30, dict[str, float]()
    moves = [(".".join(map(str, e)), [n], by_state(e)) for n, e in enumerate(whole.states) if _is_real(memory, e)]
    sizes = [abs(held_in(memory, entry, NO_RINGS)) for entry in whole.states if _is_real(memory, entry)]
    for name, port in inputs:
        own = [whole.order + i for i, entry in enumerate(whole.inputs) if entry[:2] == (name, port)]
        moves.append((name, own, by_input(name)))
        sizes.append(abs(float(after_wire(planned, memory, (name, port)))))
    for (label, columns, moved), size in zip(moves, sizes, strict=True):
        slopes, least = whole.matrix[rows][:, columns].sum(axis=1), np.full(len(rows), np.inf)
        for step in (max(size, 1e-9) * part for part in STEPS):
            by_runs = (moved(step) - moved(-step)) / (2.0 * step)
            off = np.maximum(np.abs(by_runs - slopes) - ROUNDINGS * base / step, 0.0)
            largest = max(np.abs(by_runs).max(), np.abs(slopes).max())
            least = np.minimum(least, off / (np.abs(by_runs) + np.abs(slopes) + 1e-7 * largest + 1e-300))
        found[label] = float(least.max())
    return found


def after_wire(planned: Plan, memory: Memory, node: Endpoint) -> Any:
    return Course(planned).from_memory(memory.copy()).to(memory.tick + 1).wires[node]


def _is_real(memory: Memory, entry: tuple[str, str, int]) -> bool:
    return isinstance(held_in(memory, entry, NO_RINGS), float) and entry[1] != REST


def check(name: str, folder: Path) -> None:
    for given in cases(name, folder):
        planned, inputs, outputs = given
        course = Course(planned, many=True)
        for tick in TICKS:
            memory = course.at(tick)
            try:
                whole = period_map(planned, inputs, outputs, memory=memory)
            except ModelError:
                continue
            size = np.abs(whole.matrix[:, :-1]).max(initial=0.0)
            if name not in UNROUNDED:
                code = period_map(planned, inputs, outputs, memory=memory, slopes=course.slopes).between()
                own = whole.between()
                assert code.states == own.states
                np.testing.assert_allclose(code.matrix[:, :-1], own.matrix[:, :-1], rtol=1e-9, atol=1e-12 * size)
            if BLOCK not in rounding_blocks(planned) and name not in AT_A_CORNER:
                wrong = {label: off for label, off in apart(given, whole, memory).items() if off > 1e-4}
                assert not wrong, f"tick {tick}"


@pytest.mark.parametrize("name", SAMPLE)
def test_small_signals_of_some_blocks(name: str, tmp_path: Path) -> None:
    check(name, tmp_path)


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", sorted(all_blocks()))
def test_small_signals_of_every_block(name: str, tmp_path: Path) -> None:
    check(name, tmp_path)
