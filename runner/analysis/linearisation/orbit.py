"""Linear maps about operating points that are what they claim: the orbit closes, moves slowly, or makes no difference.

A map of one common period is linear and time-invariant where the graph is the same in every period. Where carriers are
mixed it depends on their phases, and repeats only if they fit the period. So the map is compared with those of later
periods. Where they differ, it may be taken

- over k periods, if the orbit closes after k: this is exact, since the map of k periods does not change; or
- over one, if it changes little in 1 / w, w being the lowest gain crossover: a loop frozen in its motion.

A switch that waits, such as a chopper, changes nothing until then, so that a run is followed for as long as a change
would matter (`waiting`).

Otherwise no time-invariant map describes the loop, and it is refused. Tick 0 is not refused, since a graph starts there
from its initial values; a note says if it is not at rest.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.forward import Forward, memory_at
from proofmass.runner.analysis.linearisation.map_changes import LOOKS, NEAR, change_between, effect, pole_rates
from proofmass.runner.analysis.linearisation.numbers import Orbit, states_of, time_text, wires_of
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.period_map import (
    Array,
    PeriodMap,
    PointSlopes,
    blocks_of_map,
    common_period,
    period_map,
)
from proofmass.runner.analysis.linearisation.periodic import PeriodicPoint, Point
from proofmass.runner.analysis.linearisation.point_slopes import slopes_at_rest, slopes_near_start
from proofmass.runner.analysis.linearisation.waiting import Waiting, switch_note
from proofmass.runner.derivatives.dual_noise import NOTHING, Noisy
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan

SAME = 1e-9  # relative change of a map that counts as rounding
FROZEN, NOTED = 0.02, 1e-3  # largest accepted change of a loop in the time of its lowest crossover, and without a note
LONGEST_ORBIT, MOST_PERIODS = 10_000, 100  # base ticks and periods of a map over several periods
WAITED = 2  # least number of periods that a waiting switch stands still
MOST_SWITCHED = 1_000  # periods of a map over those of a switch
_BACK = 0.1  # relative difference allowed between a map of noise over several periods and the next one
_FIXED = "derivatives take the operating point as fixed: it is not at rest"


@dataclass(frozen=True)
class _Point:
    """The operating point of one map: over how many periods it is taken, and what is to be said of it."""

    map: PeriodMap
    periods: int
    notes: tuple[str, ...] = ()
    later: tuple[PeriodMap, ...] = ()
    memory: Memory | None = None
    ticks: int = 0  # base ticks of the map, where it is about an orbit that was found to close
    integrated: bool = False


def map_at(
    plan: Plan,
    inputs: Sequence[Endpoint],
    outputs: Sequence[Endpoint],
    *,
    cut: bool = False,
    everything: bool = False,
    by_parameters: bool = False,
    noise: Noisy = NOTHING,
    tick: Point = 0,
) -> PeriodMap:
    """Return `period_map` over as many periods as the orbit takes to close; raises `ModelError` if it does not."""
    if isinstance(tick, PeriodicPoint):
        point = _periodic(plan, inputs, outputs, cut, everything, noise, tick)
    else:
        wanted = (tuple(inputs), tuple(outputs), cut, everything, tuple(noise.items()), tick)
        if _Latest.plan is not plan or _Latest.wanted != wanted:
            search = _Search(plan, inputs, outputs, cut, everything, noise, tick)
            _Latest.plan, _Latest.wanted, _Latest.point = plan, wanted, search.whole_point()
        point = _Latest.point
    notes = point.notes
    exact = point.map
    if by_parameters:
        slopes, more = _point_slopes(plan, inputs, outputs, everything, noise, point)
        notes += more
        exact = period_map(
            plan,
            inputs,
            outputs,
            cut=cut,
            everything=everything,
            by_parameters=True,
            noise=noise,
            memory=point.memory,
            point_slopes=slopes,
            span=point.ticks,
            integrated=point.integrated,
        )
    return replace(exact, notes=notes, later=point.later)


def _periodic(
    plan: Plan,
    inputs: Sequence[Endpoint],
    outputs: Sequence[Endpoint],
    cut: bool,
    everything: bool,
    noise: Noisy,
    orbit: PeriodicPoint,
) -> _Point:
    """Return the map about an orbit that closes."""
    whole = period_map(
        plan,
        inputs,
        outputs,
        cut=cut,
        everything=everything,
        noise=noise,
        memory=orbit.memory,
        span=orbit.ticks,
        integrated=True,
    )
    return _Point(whole, 1, (orbit.note(plan.period),), memory=orbit.memory, ticks=orbit.ticks, integrated=True)


def _point_slopes(
    plan: Plan,
    inputs: Sequence[Endpoint],
    outputs: Sequence[Endpoint],
    everything: bool,
    noise: Noisy,
    point: "_Point",
) -> tuple[PointSlopes | None, tuple[str, ...]]:
    """Return the derivatives of the operating point by the parameters, and a note where they are not known."""
    tick = point.map.tick
    blocks = blocks_of_map(plan, inputs, outputs, everything, noise)[0]
    near = slopes_near_start(plan, blocks, tick) if tick and not plan.schedule.phases else None
    if near is not None or not tick:
        return near, ()
    whole = period_map(
        plan,
        (),
        outputs,
        everything=True,
        by_parameters=True,
        memory=point.memory,
        span=point.ticks,
        integrated=point.integrated,
    )
    at_rest = slopes_at_rest(whole)
    return at_rest, () if at_rest is not None else (_FIXED,)


class _Latest:
    """The last point, since it is asked for again with the derivatives by parameters."""

    plan: Plan | None = None
    wanted: Any = None
    point: _Point


class _Search:
    """Looks for the periods over which a map can be taken."""

    def __init__(
        self,
        plan: Plan,
        inputs: Sequence[Endpoint],
        outputs: Sequence[Endpoint],
        cut: bool,
        everything: bool,
        noise: Noisy,
        tick: int,
    ) -> None:
        self._plan, self._inputs, self._outputs = plan, inputs, outputs
        self._cut, self._everything, self._noise = cut, everything, noise
        self._ticks = common_period(plan, inputs, outputs, everything, noise)
        self._period = self._ticks * plan.period
        self._most = min(LONGEST_ORBIT // self._ticks, MOST_PERIODS)
        self._first = tick - tick % self._ticks
        upstream, moving = blocks_of_map(plan, inputs, outputs, everything, noise)
        self._names = sorted(upstream)
        run = plan.without_noise
        self._quiet = run
        self._memories = {0: memory_at(run, self._first)}
        self._run = Forward(run, self._memories[0].copy())
        self._waiting = Waiting(run, upstream, moving, self._memories[0], self._ticks)

    def whole_point(self) -> _Point:
        """The map, with the memory that it starts from and the ticks that it covers."""
        point = self.point()
        return replace(point, memory=self._memories[0], ticks=point.periods * self._ticks)

    def point(self) -> _Point:
        """The map, over how many periods it is, and what is to be said of it."""
        first = self._map(self._after(0))
        changes = self._waiting.changes(self._after, self._horizon(first))
        if not changes and not self._moves():
            return _Point(first, 1)
        maps = dict[int, PeriodMap]()
        for look in sorted({*self._looks(), *changes}):
            maps[look] = self._map(self._after(look))
            if look == 1 and not changes and self._same(first, maps[look]):
                return _Point(first, 1)
        switched = [look for look in changes if not self._same(first, maps[look])]
        if changes and not switched and self._same(first, maps[1]):
            return _Point(first, 1)
        change = self._drift(first, maps, 1, first, maps[max(maps)])
        later = tuple(maps[look] for look in LOOKS if look in maps)
        if switched and (self._noise or change > FROZEN):
            closed = self._closed(first, self._repetition())
            if closed is not None:
                return closed
        until = self._until(first, maps, switched)
        if change <= NOTED:
            return _Point(first, 1, until, later)
        if self._first == 0:
            return _Point(first, 1, until or (self._start_up(),), later)
        if change <= FROZEN:
            return _Point(first, 1, (*until, *_moving(change)), later)
        orbit = self._orbit()
        closed = self._closed(first, orbit.returns())
        if closed is None:
            raise ModelError([self._plan.graph.placed(self._refused(orbit, first))])
        return closed

    def _drift(
        self,
        of_period: PeriodMap,
        later: Mapping[int, PeriodMap],
        periods: int,
        first: PeriodMap,
        following: PeriodMap,
    ) -> float:
        """Return the change between the maps `first` and `later` of a period, in the time of the lowest crossover.

        Between wires it is the time of the slowest pole of the map `of_period`, which a `following` one repeats.
        """
        crossovers = self._crossovers(of_period)
        last = 1.0 / (2.0 * self._period * periods)
        f = np.array(crossovers) if crossovers else np.geomspace(1e-4, 0.9, 24) * last
        z = np.asarray(np.exp(2j * math.pi * f * self._period))
        shown = self._shown(first)
        speed = max(effect(shown, self._shown(after), z) / number for number, after in later.items())  # a period
        if crossovers:
            return speed / (2.0 * math.pi * crossovers[0] * self._period)
        rates, rates_later = pole_rates(of_period), pole_rates(following)
        if len(rates) != len(rates_later):  # some state begins to move or comes to rest
            rates_later = rates
        # A pole that comes much nearer to neutral later, as the phase of an oscillation that settles, is neutral.
        slow = (rates > SAME) & ((rates >= NEAR) | (rates_later > 0.5 * rates))
        return speed * periods / _slowest(rates[slow])

    def _after(self, periods: int) -> Memory:
        """Return the memory some periods after the operating point."""
        if periods not in self._memories:
            tick = self._first + periods * self._ticks
            if self._run.tick > tick:
                earlier = max(known for known in self._memories if known < periods)
                self._run = Forward(self._quiet, self._memories[earlier].copy())
            self._memories[periods] = self._run.to(tick)
        return self._memories[periods]

    def _horizon(self, first: PeriodMap) -> int:
        """Return the number of periods within which a switch of the whole loop would matter."""
        longest = LONGEST_ORBIT // self._ticks
        if self._noise:
            return longest
        crossovers = self._crossovers(first)
        rate = 2.0 * math.pi * crossovers[0] * self._period if crossovers else _slowest(pole_rates(first))
        return int(min(longest, 1.0 / (FROZEN * rate)))

    def _repetition(self) -> list[int]:
        """Return the number of periods after which all switches do as before, if there is one."""
        longest = min(LONGEST_ORBIT // self._ticks, MOST_SWITCHED)
        run = Forward(self._quiet, self._after(0).copy())
        ticks = self._ticks
        found = self._waiting.repetition(lambda n: run.to(self._first + n * ticks), longest, self._memories)
        return [found] if found else []

    def _map(self, memory: Memory, periods: int = 1) -> PeriodMap:
        return period_map(
            self._plan,
            self._inputs,
            self._outputs,
            cut=self._cut,
            everything=self._everything,
            noise=self._noise,
            memory=memory.copy(),
            periods=periods,
        )

    def _same(self, first: PeriodMap, after: PeriodMap) -> bool:
        return change_between(self._shown(first), self._shown(after)) <= SAME

    def _shown(self, of: PeriodMap) -> PeriodMap:
        """Return the map to the outputs that are asked for, without those of quantisers, which may be thousands."""
        if not self._noise:
            return of
        n, wanted = of.order, [i for i, entry in enumerate(of.outputs) if entry[:2] in self._outputs]
        rows = [*range(n), *(n + i for i in wanted)]
        return replace(of, outputs=tuple(of.outputs[i] for i in wanted), matrix=of.matrix[rows], slopes={})

    def _looks(self) -> tuple[int, ...]:
        """Return the periods after which the map is compared."""
        return tuple(look for look in LOOKS if look == 1 or not self._noise or look * self._ticks <= LONGEST_ORBIT)

    def _moves(self) -> bool:
        """Return whether anything that the map depends on changes: states, or wires in the last tick of a period."""
        before, once, twice = map(self._after, range(3))
        if dict(states_of(once, self._names)) != dict(states_of(before, self._names)):
            return True
        return dict(wires_of(once, self._names)) != dict(wires_of(twice, self._names))

    def _crossovers(self, of_period: PeriodMap) -> list[float]:
        """Return where |L| of a loop is about 1, in Hz."""
        if not self._cut:
            return []
        system = OpenLoop(of_period.between())
        w = np.geomspace(1e-9, 0.999, 900) * math.pi / system.sample
        above = np.abs(system.response(w)) > 1.0
        return [float(w[i]) / (2.0 * math.pi) for i in np.flatnonzero(above[:-1] != above[1:])]

    def _closed(self, first: PeriodMap, returns: Iterable[int]) -> _Point | None:
        """The map over so many periods that the orbit comes back."""
        for periods in returns:
            closed = self._map(self._after(0), periods)
            after = self._map(self._after(periods), periods)
            change = self._drift(closed, {periods: self._map(self._after(periods))}, periods, first, after)
            if self._noise and change_between(self._shown(closed), self._shown(after)) > _BACK:
                continue
            if change <= FROZEN:
                once, whole = time_text(self._period), time_text(periods * self._period)
                note = f"linearised over {whole}, in which the orbit closes, not over the {once} of the schedule"
                return _Point(closed, periods, (note, *_moving(change)), (after,))
        return None

    def _orbit(self) -> "Orbit":
        later = map(self._after, range(1, 2 + self._most))
        rows = [dict(states_of(m, self._names)) | dict(wires_of(m, self._names)) for m in later]
        return Orbit(rows, paired=bool(self._noise))

    def _until(self, first: PeriodMap, maps: Mapping[int, PeriodMap], switched: Sequence[int]) -> tuple[str, ...]:
        """Return what is to be said of a switch that has waited, if it matters."""
        shown = self._shown(first)
        for look in switched[:1]:
            if look > WAITED and change_between(shown, self._shown(maps[look])) > FROZEN:
                return (switch_note(look * self._period),)
        return ()

    def _start_up(self) -> str:
        return (
            'tick 0 is a start-up, and the loop changes afterwards: use --at settled, or a time, such as --at "0.1 s"'
        )

    def _refused(self, orbit: "Orbit", found: PeriodMap) -> Problem:
        name, part, step = orbit.fastest()
        turning = any(True for _ in orbit.turning)
        crossed = ", ".join(f"{f:.3g} Hz" for f in self._crossovers(found)[:4])
        crossed = crossed and f", which would put crossovers at {crossed}"
        period, longest = time_text(self._period), time_text(self._most * self._period)
        return Problem(
            message=f"the operating point does not repeat in {period}, the period of the schedule",
            key=f"blocks.{name}",
            got=f"{part} changes by {step:.2g} of its swing from one period to the next{crossed}",
            expected=f"an orbit that closes in {period}, or in up to {longest}"
            if turning
            else "an operating point at rest",
            hint=f"take --at periodic if the loops have not settled yet; else choose rates so that a whole number of"
            f" carrier periods fits {period}, or model the loop at baseband"
            if turning
            else "take a later time, or --at settled",
            path=("blocks", name),
        )


def _slowest(rates: Array) -> float:
    """Return the least rate of those that are not neutral, a period; 1 if there is none."""
    return float(np.min(rates, where=rates > SAME, initial=1.0))


def _moving(change: float) -> tuple[str, ...]:
    return (f"the operating point moves: the loop is wrong by some {100.0 * change:.1g} %",) if change > NOTED else ()
