"""The operating point at which the loops of a graph have come to rest.

The graph runs for 1, 2, 4, 8, 16, 31, 59, ... of its common periods, by 15/8 longer each time so that no period of a
signal hides in them. It is settled when twice in a row no number that blocks in loops hold has moved by more than
`TOLERANCE` of the largest it has been, which leaves room for the dither of converters. What decays with a time constant
has then done so to the 3.5th power of that, however long the constant is and however short the ticks. Integers and
switches, which count, are not looked at.
"""

import math
from collections.abc import Iterator
from dataclasses import replace

import networkx

from proofmass.blocks.problem import ModelError, Problem
from proofmass.runner.engine.engines import choose, make_engine
from proofmass.runner.engine.interpret import TickError
from proofmass.runner.engine.memory import Memory, start
from proofmass.runner.engine.planned import Plan
from proofmass.runner.margins.period_map import plan_graph

TOLERANCE = 1e-2
FEWEST, MOST = 64, 1 << 20  # base ticks
Number = tuple[str, str, int]  # block, field or buffer, and index in the buffer


def settled_tick(plan: Plan) -> int:
    """The base tick by which the loops have settled; raises `ModelError` with what still moves, and by how much."""
    names = sorted(_in_loops(plan))
    ticks = math.lcm(*(plan.schedule.divisors[name] for name in names)) if names else 1
    silent, memory, periods, still, got = replace(plan, probes=()), start(plan), 0, 0, ""
    largest, before = dict[Number, float](), dict(_numbers(memory, names))
    while memory.tick < MOST:
        earlier, periods = memory.tick, periods * 15 // 8 + 1
        memory = _run(silent, memory, ticks * periods)
        now = dict(_numbers(memory, names))
        largest = {key: max(largest.get(key, 0.0), abs(value)) for key, value in now.items()}
        moved = {key: abs(value - before[key]) / (largest[key] or 1.0) for key, value in now.items()}
        worst = max(moved, key=lambda key: moved[key], default=None)
        still = still + 1 if worst is None or moved[worst] <= TOLERANCE else 0
        if still >= 2 and memory.tick >= FEWEST:
            return memory.tick
        if worst is not None:
            what = f"{worst[0]}.{worst[1]}" + (f"[{worst[2]}]" if worst[2] >= 0 else "")
            share = f"{moved[worst]:.2g} of its largest value"
            got = f"{what} moves by {share}, from {earlier:,} ticks to {memory.tick:,}"
        before = now
    raise ModelError([plan.graph.placed(_restless(got))])


def _run(plan: Plan, memory: Memory, last: int) -> Memory:
    """The memory at a later tick."""
    engine = make_engine(plan, choose(plan, last - memory.tick, "auto"), plan.graph.seed, 0, memory)
    try:
        finite = engine.advance(last, ())
    except TickError as error:
        raise ModelError([plan.graph.placed(_restless(str(error)))]) from error
    if not finite:
        raise ModelError([plan.graph.placed(_restless(f"a number is not finite before tick {last:,}"))])
    return engine.memory()


def _in_loops(plan: Plan) -> set[str]:
    """Blocks that act on themselves, at once or by way of others."""
    wiring = plan_graph(plan)
    parts = networkx.strongly_connected_components(wiring)
    return {name for part in parts for name in part if len(part) > 1 or wiring.has_edge(name, name)}


def _numbers(memory: Memory, names: list[str]) -> Iterator[tuple[Number, float]]:
    """The real numbers that blocks hold."""
    for name in names:
        state = memory.states[name]
        if state is not None:
            kinds = state.__annotations__
            yield from (((name, f, -1), getattr(state, f)) for f in state._fields if kinds[f] is float)
    for (name, buffer), held in memory.buffers.items():
        if name in names:
            yield from (((name, buffer, i), float(v)) for i, v in enumerate(held) if isinstance(v, float))


def _restless(got: str) -> Problem:
    return Problem(
        message="the loops do not settle",
        key="at",
        got=got,
        expected=f"{TOLERANCE:g} at most, in {MOST:,} base ticks",
        hint="take out noise and what goes on changing, or name a time instead, as in 20 ms",
    )
