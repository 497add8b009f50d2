"""The operating point at which the loops of a graph have come to rest.

The graph runs for 1, 2, 4, 8, 16, 31, 59, ... of its common periods, 15/8 as long each time so that no periodic signal
can hide. It has settled when twice in a row no state of blocks in loops has changed by more than `TOLERANCE` of its
largest value, which leaves room for the dither of converters. A decaying mode has then decayed to the 3.5th power of
`TOLERANCE`, whatever its time constant and the length of a tick. Integers and switches are left out. Loops that are
unstable in tick 0 may still settle at a limit.
"""

import math

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.digraph import loops
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.rings import Entry
from proofmass.runner.analysis.linearisation.seeds import NO_RINGS
from proofmass.runner.host.progress import Progress
from proofmass.runner.plan.memory import Memory, start

TOLERANCE = 1e-2
FEWEST, MOST = 64, 1 << 20  # base ticks


def settled_tick(course: Course, progress: Progress | None = None) -> int:
    """Return the base tick by which the loops have settled; raises `ModelError` that names what still moves."""
    plan = course.plan
    names = sorted(set[str]().union(*loops(plan.readers)))
    ticks = math.lcm(*(plan.schedule.divisors[name] for name in names)) if names else 1
    memory, periods, still, got = start(plan), 0, 0, ""
    largest, before = dict[Entry, float](), _numbers(memory, names)
    while memory.tick < MOST:
        earlier, periods = memory.tick, periods * 15 // 8 + 1
        try:
            memory = course.at(ticks * periods, progress, MOST)
        except ModelError as error:
            raise plan.graph.placed(_restless(error.problems[0].message)).error from error
        now = _numbers(memory, names)
        largest = {key: max(largest.get(key, 0.0), abs(value)) for key, value in now.items()}
        change = {key: abs(value - before[key]) / (largest[key] or 1.0) for key, value in now.items()}
        worst = max(change, key=lambda key: change[key], default=None)
        still = still + 1 if worst is None or change[worst] <= TOLERANCE else 0
        if still >= 2 and memory.tick >= FEWEST:
            return memory.tick
        if worst is not None:
            what = f"{worst[0]}.{worst[1]}" + (f"[{worst[2]}]" if worst[2] >= 0 else "")
            share = f"{change[worst]:.2g} of its largest value"
            got = f"{what} moves by {share}, from {earlier:,} ticks to {memory.tick:,}"
        before = now
    raise plan.graph.placed(_restless(got)).error


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
