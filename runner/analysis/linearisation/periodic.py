"""Periodic operating points: carriers, choppers and drives come back after a period, and are found by shooting.

    x = F(x),   x <- x + (I - A)^-1 (F(x) - x)

F is what a run of the graph over a period makes of the states, without noise, and A its exact
derivative. In F, as in A, quantisers pass their input on. Continuous groups that are not linear are
moved by the run's own integration.

The period is the least of 1 to 2,000 common periods of all blocks after which a run comes close to
where it was. A point counts as periodic where all that acts on others is back to 1e-10 of its size,
after one period and after two.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.numbers import Orbit, wires_of
from proofmass.runner.analysis.linearisation.period_map import PeriodMap, period_map
from proofmass.runner.analysis.linearisation.rings import Entry
from proofmass.runner.analysis.linearisation.seeds import NO_RINGS
from proofmass.runner.analysis.linearisation.surroundings import moved
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan

CLOSED = 1e-10  # part of the size of the states by which an orbit may miss its start
LONGEST = 10_000  # base ticks of a period
_SPANS = (100, 2000)  # common periods of the two runs in which an orbit is looked for
_LONG, _FEW = 100, 4  # beyond so many common periods only the closest orbit is tried, in few steps
_SETTLING = 20_000  # base ticks of a run before the search, at most
_LOOKS = 500  # most comparisons over the longest run, for slow movements
_STEPS, _NO_NEARER = 30, 10  # of Newton's method, in all and one after the other without coming nearer than before
_NULL = 1e-11  # part of the largest singular one: a direction on which nothing depends, as a phase
_FAR = 0.1  # of its size, by which a state may differ from that of a run
_SAME = 1e-8  # relative difference allowed between the maps of two periods


@dataclass(frozen=True)
class PeriodicPoint:
    """Operating point that comes back: memory, base ticks of the period, and how well it closes."""

    memory: Memory
    ticks: int
    misfit: float  # of the size of the states
    steps: int
    moving: str = ""  # a signal that moves one way instead of repeating

    def note(self, period: float) -> str:
        """Return the remark about it in an analysis."""
        return (
            f"about a periodic orbit of {self.ticks * period:.6g} s, found in {self.steps} steps,"
            f" that closes to {self.misfit:.1g}" + (f", while {self.moving} moves on" if self.moving else "")
        )


OperatingPoint = int | PeriodicPoint  # base tick of an operating point, or one that comes back


def periodic_point(course: Course) -> PeriodicPoint:
    """Return the periodic operating point of a graph; raises `ModelError` where none is found."""
    plan = course.plan
    common = math.lcm(*plan.schedule.divisors.values())
    if common > LONGEST:
        raise plan.graph.placed(_too_long(plan, common)).error
    search = _Shooting(course, common)
    best = ""
    for periods in search.candidates():
        point, best = search.newton(periods, best)
        if point is not None:
            return point
    raise plan.graph.placed(_none(plan, search, best)).error


class _Shooting:
    """Newton's method on the period map, from where a run has got to."""

    def __init__(self, course: Course, common: int) -> None:
        self.course, self.plan, self.common = course, course.plan, common
        self.outputs = list(_numbers(self.plan))
        self.first = max(1, min(_SETTLING, 4096 * common) // common) * common
        self._sizes: dict[Entry, float] = {}
        self.spans = [*dict.fromkeys(min(span, LONGEST // common) for span in _SPANS)]
        self._span = self.spans[0]
        names = sorted(self.plan.blocks)
        for tick in _looks(self.common, self.first):
            self._start = course.at(tick)
            for entry, value in (*NO_RINGS.states_of(self._start, names), *wires_of(self._start, names)):
                self._sizes[entry] = max(self._sizes.get(entry, 0.0), abs(float(value)))

    def candidates(self) -> Iterator[int]:
        """Yield how many common periods the orbit may take: one, and those that a run takes."""
        yield 1
        tried = {1}
        for span in self.spans:
            self._span = span
            vars(self).pop("_orbit", None)
            several = [periods for periods in self._orbit.returns() if periods not in tried]
            several = several if span <= _LONG else several[-1:]  # the last one is the closest
            tried |= {*several}
            yield from several

    @cached_property
    def _slow(self) -> tuple[set[Entry], str]:
        """Signals that go one way at first and turn later, as a slow carrier; and one that has not turned at all."""
        wires = self._start.wires
        first = {key for key in self._orbit.straight_keys if isinstance(wires.get(key[:2]), float)}
        if not first:
            return set(), ""
        step = max(1, LONGEST // self.common // _LOOKS) * self.common
        run, names = self.course.from_memory(self._start), sorted(self.plan.blocks)
        ticks = (self.first + i * step for i in range(1, _LOOKS + 1))
        later = Orbit([dict(wires_of(m, names)) for m in map(run.to, ticks)], True, self._sizes)
        turned = first & {*later.turning_keys}
        left = sorted(first & {*later.straight_keys})
        return turned, ".".join(left[0][:2]) if left else ""

    @cached_property
    def _orbit(self) -> Orbit:
        run, names = self.course.from_memory(self._start), sorted(self.plan.blocks)
        ticks = (self.first + i * self.common for i in range(1, self._span + 2))
        return Orbit(
            [dict(NO_RINGS.states_of(m, names)) | dict(wires_of(m, names)) for m in map(run.to, ticks)],
            True,
            self._sizes,
        )

    def newton(self, periods: int, before: str) -> tuple[PeriodicPoint | None, str]:
        """Return the point over so many common periods, or None and what is in its way."""
        memory, worst, misfits = self._start.copy(), before, list[float]()
        for steps in range(1, (_STEPS if periods <= _LONG else _FEW) + 1):
            try:
                whole = self.map(memory, periods)
            except ModelError:
                if steps == 1:
                    raise
                return None, before  # far from any orbit
            scale = self._scale(whole)
            change, misfit, drift = _newton_step(whole, scale)
            if not np.isfinite(change).all():
                return None, before
            worst = _worst(whole, drift, scale) or worst
            misfits.append(misfit)
            if steps > misfits.index(min(misfits)) + _NO_NEARER:
                break
            if misfit <= CLOSED:
                wrong = self._wrong(whole, memory, scale, periods)
                return (
                    (None, wrong)
                    if wrong
                    else (PeriodicPoint(memory, periods * self.common, misfit, steps, self._slow[1]), "")
                )
            by = {entry: step for entry, step in zip(whole.states, change.tolist(), strict=True) if step}
            memory = moved(memory, by, NO_RINGS)
        return None, worst

    def _wrong(self, whole: PeriodMap, memory: Memory, scale: Array, periods: int) -> str:
        """Return why a point is not periodic although its states come back, or ""."""
        end = whole.end or memory
        names = sorted(self.plan.blocks)
        first, last = dict(NO_RINGS.states_of(memory, names)), dict(NO_RINGS.states_of(end, names))
        size = dict(zip(whole.states, scale, strict=True))
        turning = {*self._orbit.turning_keys} | self._slow[0]
        for key in sorted(turning):
            if key in first and abs(last[key] - first[key]) > CLOSED * size.get(key, 1.0):
                return f"{key[0]}.{key[1]} is {last[key]:g} after a period, and was {first[key]:g}"
        after = self.map(end, periods)
        wires = [end.wires, (after.end or end).wires]
        same = all(
            abs(wires[1][key] - wires[0][key]) <= _SAME * max(abs(wires[0][key]), self._sizes.get(entry, 0.0))
            for entry, key in ((entry, entry[:2]) for entry in turning if entry[:2] in end.wires)
        )
        if not same or after.states != whole.states or not _alike(whole, after, scale):
            return "the period that follows is another: a signal of the time does not fit it"
        run = NO_RINGS.states_of(self._start, names)
        moved = max((abs(first[key] - value) / size[key] for key, value in run if key in size), default=0.0)
        if moved > _FAR and np.max(np.abs(np.linalg.eigvals(whole.parts()[0])), initial=0.0) > 1.0 + _SAME:
            return "Newton's method goes to an unstable point far from where a run gets to"
        return ""

    def _scale(self, whole: PeriodMap) -> Array:
        """Return the largest values that states have had, or one where they were zero in the run, as of noise."""
        sizes = ((self._sizes.get(e, 0.0), abs(x)) for e, x in zip(whole.states, whole.point, strict=True))
        return np.array([max(largest, now) if largest else 1.0 for largest, now in sizes])

    def map(self, memory: Memory, periods: int) -> PeriodMap:
        """Return the map of all states over some common periods."""
        return period_map(
            self.plan, (), self.outputs, everything=True, memory=memory, span=periods * self.common, integrated=True
        )


def _looks(common: int, last: int) -> Iterator[int]:
    """Yield ticks at which the sizes of states are looked at."""
    tick = common
    while tick < last:
        yield tick
        tick *= 2
    yield last


def _newton_step(whole: PeriodMap, scale: Array) -> tuple[Array, float, Array]:
    """Return the change of the states that closes the orbit, its misfit, and what of it cannot be closed.

    What every period leaves as it is stays: coefficients in buffers would else be moved to close
    the orbit.
    """
    a, step = whole.parts()[0], whole.matrix[: whole.order, -1]
    if not len(a):
        return np.zeros(0), 0.0, np.zeros(0)
    system = np.eye(len(a)) - a / scale[:, None] * scale
    moving = whole.moving()
    change = np.zeros(len(a))
    change[moving] = np.linalg.pinv(system[:, moving], rcond=_NULL) @ (step / scale)
    closing = system @ change
    return change * scale, float(np.max(np.abs(closing))), step / scale - closing


def _alike(first: PeriodMap, second: PeriodMap, scale: Array) -> bool:
    """Return whether two maps are the same in units of the states."""
    n = first.order
    apart = np.abs(second.matrix[:n] - first.matrix[:n]) / scale[:, None]
    apart[:, :n] *= scale
    return bool(np.max(apart, initial=0.0) <= _SAME)


def _worst(whole: PeriodMap, drift: Array, scale: Array) -> str:
    """Return the state that misses most, in words."""
    step = np.abs(whole.matrix[: whole.order, -1]) / scale
    if not len(step):
        return ""
    at = int(np.argmax(np.maximum(step, np.abs(drift))))
    return f"{whole.names([whole.states[at]])[0]} misses where it was by {step[at]:.2g} of its size"


def _numbers(plan: Plan) -> Iterator[Endpoint]:
    """Yield an output of each block that has one that is a number."""
    for name, block in plan.blocks.items():
        for port, declared in type(block).outputs.items():
            if declared.is_number:
                yield name, port
                break


def _none(plan: Plan, search: _Shooting, worst: str) -> Problem:
    period = search.common * plan.period
    return Problem(
        message="no periodic operating point was found",
        key="at",
        got=worst,
        expected=f"an orbit that closes in {period:.6g} s, or in a whole number of these up to {search.spans[-1]}",
        hint="choose rates so that a whole number of ticks fits each carrier; an oscillator without a drive has a"
        " period of its own, which no number of ticks need fit: drive it",
    )


def _too_long(plan: Plan, common: int) -> Problem:
    return Problem(
        message="the blocks tick together too rarely for a periodic operating point",
        key="rate",
        got=f"{common:,} base ticks, {common * plan.period:.6g} s",
        expected=f"at most {LONGEST:,} base ticks",
        hint="make the rates ratios of small numbers",
    )
