"""The operating point at which the loops of a graph have come to rest.

The graph runs for 1, 2, 4, 8, 16, 31, 59, ... of its common periods, 15/8 as long each time so that
no periodic signal can hide. It has settled when twice in a row no state of blocks in loops has
changed by more than `TOLERANCE` of its largest value, which leaves room for the dither of
converters, and none is under way to more than that. A decaying mode has then decayed to the 3.5th
power of `TOLERANCE`, whatever its time constant and the length of a tick. Integers and switches are
left out. Loops that are unstable in tick 0 may still settle at a limit.

A slow mode hardly moves between two looks. It shows in equal steps before a look: a state that goes
one way in all of them goes on by d r / (1 - r), with its last step d and their quotient r, as a
geometric series does. States of blocks before loops count while they go one way, as of the slow
filter of a reference. In a graph without loops those of all blocks count as those in loops do.
"""

import math
from collections.abc import Callable, Iterator
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.checks.schedule import outputs_of
from proofmass.graphs.model.digraph import loops
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.map_blocks import upstream_of
from proofmass.runner.analysis.linearisation.rings import Entry
from proofmass.runner.analysis.linearisation.seeds import NO_RINGS
from proofmass.runner.host.arrays import Array, Truths
from proofmass.runner.host.progress import Progress
from proofmass.runner.plan.memory import start
from proofmass.runner.plan.planned import Plan

TOLERANCE = 1e-2
FEWEST, MOST = 64, 1 << 20  # base ticks
_STEPS = 8  # before each look


@dataclass(frozen=True)
class RestingNumbers:
    """Real numbers that blocks of a plan remember, which must come to rest."""

    entries: tuple[Entry, ...]
    begin: Array
    own: Truths  # those of blocks in loops, all without any
    ticks: int  # after which these tick together again
    looped: frozenset[str]


class SettlingLook(NamedTuple):
    """Motion of numbers up to a tick, a row for each run, and which runs have settled by then."""

    earlier: int
    tick: int
    moves: Array
    ways: Array  # they are under way to
    shares: Array  # of the larger of both, of the largest values
    settled: Truths


def resting_numbers(plan: Plan) -> RestingNumbers:
    """Return what must come to rest in a plan."""
    looped = set[str]().union(*loops(plan.readers))
    # what measures sum up goes on, and is in no order
    names = sorted(upstream_of(plan, looped or {name for name, _ in outputs_of(plan.schedule.order)}))
    ticks = math.lcm(*(plan.schedule.divisors[name] for name in looped or names))
    begin = dict(NO_RINGS.states_of(start(plan), names, float))
    own = np.array([name in (looped or names) for name, _, _ in begin], dtype=bool)
    return RestingNumbers(tuple(begin), np.array([*begin.values()]), own, ticks, frozenset(looped))


def looks(of: RestingNumbers, runs: int, numbers: Callable[[int], Array]) -> Iterator[SettlingLook]:
    """Yield what is seen of some runs, look after look; `numbers` returns theirs at the start of a tick, a row each."""
    periods, ticks = 0, of.ticks
    rows = {0: np.broadcast_to(of.begin, (runs, len(of.begin)))}
    largest, still = np.zeros_like(rows[0]), np.zeros(runs, dtype=np.int64)
    while ticks * periods < MOST:
        earlier, periods = periods, periods * 15 // 8 + 1
        step = max(1, (periods - earlier) // _STEPS)
        places = range(max(periods % step, periods - _STEPS * step), periods + 1, step)
        rows |= {at: numbers(ticks * at) for at in places if at not in rows}
        tick, largest = ticks * periods, np.maximum(largest, np.abs(rows[periods]))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # what grows leaves all numbers
            one_way, ways = _ways(np.array([rows[at] for at in places]), (MOST - tick) / (ticks * step))
            moves = np.abs(rows[periods] - rows[earlier]) * (of.own | one_way)
            shares = np.divide(np.maximum(moves, ways), largest, out=np.zeros_like(largest), where=largest > 0.0)
        still = np.where((shares <= TOLERANCE).all(axis=1), still + 1, 0)
        yield SettlingLook(ticks * earlier, tick, moves, ways, shares, (still >= 2) & (tick >= FEWEST))


def settled_tick(course: Course, progress: Progress | None = None) -> int:
    """Return the base tick by which the loops have settled; raises `ModelError` that names what still moves."""
    plan, of, got = course.plan, resting_numbers(course.plan), ""
    try:
        for look in looks(of, 1, lambda tick: course.numbers(of.entries, tick, progress, MOST)[None]):
            if look.settled[0]:
                return look.tick
            shares = look.shares[0]
            worst = int(np.argmax(shares)) if len(shares) else None
            if worst is not None and (shares[worst] > TOLERANCE or not got):
                name, part, number = of.entries[worst]
                what = f"{name}.{part}" + (f"[{number}]" if number >= 0 else "")
                verb = "moves" if look.moves[0, worst] >= look.ways[0, worst] else "is under way to move"
                span = f"from {look.earlier:,} ticks to {look.tick:,}"
                got = f"{what} {verb} by {shares[worst]:.2g} of its largest value, {span}"
    except ModelError as error:
        failed = f"{error.problems[0].key} {error.problems[0].message}"
        raise plan.graph.placed(_restless(failed, of.looped)).error from error
    raise plan.graph.placed(_restless(got, of.looped)).error


def _ways(values: Array, far: float) -> tuple[Truths, Array]:
    """Return which numbers go one way, and how far they go on, in `far` steps at most; 0 of those that do not."""
    steps = np.diff(values, axis=0)
    if len(steps) < 2:
        return np.zeros(values.shape[1:], dtype=bool), np.zeros(values.shape[1:])
    ratio = steps[-1] / steps[-2]
    on = np.where(ratio < 1.0, np.minimum(ratio / (1.0 - ratio), far), far)
    one_way = (steps > 0.0).all(axis=0) | (steps < 0.0).all(axis=0)
    return np.asarray(one_way), np.where(one_way, np.abs(steps[-1]) * on, 0.0)


def _restless(got: str, looped: AbstractSet[str]) -> Problem:
    return Problem(
        message="the loops do not settle" if looped else "the graph does not settle",
        key="at",
        got=got,
        expected=f"{TOLERANCE:g} at most, in {MOST:,} base ticks",
        hint="leave --at out: then a later point or a periodic one is looked for; or name a time, such as 20 ms",
    )
