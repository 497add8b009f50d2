"""Any legal order gives the same bits, in random graphs of all blocks, at several rates, nested and driven."""

import random
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from proofmass.graphs.checks.schedule import ConstantsOf
from proofmass.graphs.model.flatten import flatten
from proofmass.runner.plan.memory import Memory
from proofmass.runner.planning.plan import Plan, plan
from proofmass.runner.reference.interpret import Interpreter, TickError
from proofmass.runner.targets.native import CompiledLoop
from tests.by_hand.amounts import amounts
from tests.by_hand.orders import in_another_order, needs, shuffled
from tests.by_hand.random_graphs import KINDS, random_graphs

TICKS = 200
MEAN = 5.5  # blocks that are dealt to a graph


def outcome(engine: type[Interpreter] | type[CompiledLoop], planned: Plan) -> tuple[list[bytes], int, Memory]:
    """Every output in every tick as bytes, the ticks that were run, and what moves after the last."""
    rows: list[Any] = [np.zeros((p.rows(0, TICKS), *p.shape), dtype=p.dtype) for p in planned.probes]
    runs = engine(planned, planned.graph.seed)
    ticks = TICKS
    try:
        runs.advance(TICKS, rows)
    except TickError as fault:  # which of several numbers is named depends on the order, the tick does not
        ticks = fault.tick
    return [array.tobytes() for array in rows], ticks, runs.memory()


@pytest.mark.parametrize("count", amounts(5, 470))
def test_random_graphs_in_other_orders(count: int, tmp_path: Path) -> None:
    kinds: Counter[type] = Counter()
    orders = ran = parts = several_rates = driven = 0
    for graph in random_graphs(range(count), tmp_path):
        dice = random.Random(graph.name)
        planned = plan(graph)
        rows, ticks, memory = outcome(Interpreter, planned)
        for _ in range(2):
            other = in_another_order(plan(shuffled(graph, dice)), dice)
            other_rows, other_ticks, other_memory = outcome(Interpreter, other)
            assert other_ticks == ticks, graph
            different = [probe.signal for probe, a, b in zip(planned.probes, rows, other_rows, strict=True) if a != b]
            assert not different, (different, graph)
            assert other_memory == memory or ticks < TICKS, graph
            orders += other.schedule.order != planned.schedule.order
        ran += ticks == TICKS
        parts += bool(graph.subgraphs)
        several_rates += len(set(planned.schedule.divisors.values())) > 1
        driven += any(isinstance(step, ConstantsOf) for step in planned.schedule.order)
        kinds.update(map(type, flatten(graph).blocks.values()))
    if count * MEAN < len(KINDS):
        return
    # The graphs are what they are meant to be:
    assert set(kinds) == set(KINDS)
    assert min(kinds.values()) >= MEAN * count // len(KINDS)  # whole decks
    assert orders > 390 / 360 * count
    assert ran > 180 / 360 * count  # the others end where a cast to fixed point refuses a number
    assert parts > 50 / 360 * count
    assert several_rates > 180 / 360 * count
    assert driven > 50 / 360 * count


@pytest.mark.exhaustive
def test_ten_random_graphs_compiled_in_other_orders(tmp_path: Path) -> None:
    """The reference engine runs them in the order of the schedule; machine code says that one fails, not where."""
    for graph in random_graphs(range(1000, 1010), tmp_path, largest=3):
        planned = plan(graph)
        expected, other = outcome(Interpreter, planned), in_another_order(planned, random.Random(graph.name))
        if expected[1] < TICKS:
            rows: list[Any] = [np.zeros((p.rows(0, TICKS), *p.shape), dtype=p.dtype) for p in planned.probes]
            assert not CompiledLoop(other, graph.seed).advance(TICKS, rows), graph
            continue
        assert outcome(CompiledLoop, other) == expected, graph


@pytest.mark.exhaustive
def test_the_schedule_of_a_random_graph_keeps_what_is_needed_before(tmp_path: Path) -> None:
    for graph in random_graphs(range(2000, 2050), tmp_path):
        planned = plan(graph)
        at = {node: index for index, node in enumerate(planned.schedule.order)}
        needed = needs(planned.graph)
        assert set(at) == set(needed)
        assert all(at[before] < at[node] for node, befores in needed.items() for before in befores)
