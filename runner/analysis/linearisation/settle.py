"""The operating point at which the loops of a graph have come to rest.

The graph runs for 1, 2, 4, 8, 16, 31, 59, ... of its common periods, 15/8 as long each time so that no periodic signal
can hide. It has settled when twice in a row no state of blocks in loops has changed by more than `TOLERANCE` of its
largest value, which leaves room for the dither of converters, and none is under way to more than that. A decaying mode
has then decayed to the 3.5th power of `TOLERANCE`, whatever its time constant and the length of a tick. Integers and
switches are left out. Loops that are unstable in tick 0 may still settle at a limit.

A slow mode hardly moves between two looks. It shows in equal steps before a look: a state that goes one way in all of
them goes on by d r / (1 - r), with its last step d and their quotient r, as a geometric series does. States of
blocks before loops count so too, as of the slow filter of a reference.
"""

import math
from collections.abc import Sequence
from itertools import pairwise

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.digraph import loops, turned, with_following
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.rings import Entry
from proofmass.runner.analysis.linearisation.seeds import NO_RINGS
from proofmass.runner.host.progress import Progress
from proofmass.runner.plan.memory import Memory, start

TOLERANCE = 1e-2
FEWEST, MOST = 64, 1 << 20  # base ticks
_STEPS = 8  # before each look


def settled_tick(course: Course, progress: Progress | None = None) -> int:
    """Return the base tick by which the loops have settled; raises `ModelError` that names what still moves."""
    plan = course.plan
    looped = set[str]().union(*loops(plan.readers))
    names = sorted(with_following(looped, turned(plan.readers).__getitem__))
    ticks = math.lcm(*(plan.schedule.divisors[name] for name in looped)) if looped else 1
    periods, still, got = 0, 0, ""
    rows, largest = {0: _numbers(start(plan), names)}, dict[Entry, float]()
    while ticks * periods < MOST:
        earlier, periods = periods, periods * 15 // 8 + 1
        step = max(1, (periods - earlier) // _STEPS)
        looks = range(max(periods % step, periods - _STEPS * step), periods + 1, step)
        try:
            rows |= {at: _numbers(course.at(ticks * at, progress, MOST), names) for at in looks if at not in rows}
        except ModelError as error:
            raise plan.graph.placed(_restless(error.problems[0].message)).error from error
        tick, largest = ticks * periods, {key: max(largest.get(key, 0.0), abs(x)) for key, x in rows[periods].items()}
        far = (MOST - tick) / (ticks * step)
        moves = {key: abs(x - rows[earlier][key]) * (key[0] in looped) for key, x in rows[periods].items()}
        ways = {key: _way([rows[at][key] for at in looks], far) for key in moves}
        shares = {key: max(moves[key], ways[key]) / (largest[key] or 1.0) for key in moves}
        worst = max(shares, key=lambda key: shares[key], default=None)
        still = still + 1 if worst is None or shares[worst] <= TOLERANCE else 0
        if still >= 2 and tick >= FEWEST:
            return tick
        if worst is not None and (shares[worst] > TOLERANCE or not got):
            what = f"{worst[0]}.{worst[1]}" + (f"[{worst[2]}]" if worst[2] >= 0 else "")
            verb = "moves" if moves[worst] >= ways[worst] else "is under way to move"
            span = f"from {ticks * earlier:,} ticks to {tick:,}"
            got = f"{what} {verb} by {shares[worst]:.2g} of its largest value, {span}"
    raise plan.graph.placed(_restless(got)).error


def _way(values: Sequence[float], far: float) -> float:
    """Return how far values that go one way go on, in `far` steps at most; 0 of those that go to and fro."""
    steps = [later - earlier for earlier, later in pairwise(values)]
    if len(steps) < 2 or not (all(step > 0.0 for step in steps) or all(step < 0.0 for step in steps)):
        return 0.0
    ratio = steps[-1] / steps[-2]
    return abs(steps[-1]) * (min(ratio / (1.0 - ratio), far) if ratio < 1.0 else far)


def _numbers(memory: Memory, names: list[str]) -> dict[Entry, float]:
    """Return the real numbers in the states of blocks."""
    return {entry: value for entry, value in NO_RINGS.states_of(memory, names) if isinstance(value, float)}


def _restless(got: str) -> Problem:
    return Problem(
        message="the loops do not settle",
        key="at",
        got=got,
        expected=f"{TOLERANCE:g} at most, in {MOST:,} base ticks",
        hint="leave --at out: then a later point or a periodic one is looked for; or name a time, such as 20 ms",
    )
