"""Linear maps about operating points that are what they claim: the orbit closes, moves slowly, or makes no difference.

A map of one common period is linear and time-invariant where the graph is the same in every period.
Where carriers are mixed it depends on their phases, and repeats only if they fit the period. So the
map is compared with those of later periods. Where they differ, it may be taken

- over k periods, if the orbit closes after k: this is exact, since the map of k periods does not change; or
- over one, if it changes little in 1 / w, w being the lowest gain crossover: a loop frozen in its motion.

A switch that waits, such as a chopper, changes nothing until then, so that a run is followed for as
long as a change would matter (`waiting`).

Otherwise no time-invariant map describes the loop, and it is refused. Tick 0 is not refused, since
a graph starts there from its initial values; a note says if it is not at rest.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.graph import split
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Onward
from proofmass.runner.analysis.linearisation.map_blocks import LONGEST_PERIOD, MOST_VALUES
from proofmass.runner.analysis.linearisation.map_changes import (
    LOOKS,
    NEAR,
    change_between,
    pole_rates,
    same_between,
)
from proofmass.runner.analysis.linearisation.motion import INSTANTS, LONGEST, jumps, moves_limits
from proofmass.runner.analysis.linearisation.numbers import Orbit, time_text
from proofmass.runner.analysis.linearisation.orbit_run import FEW, ComparedMaps, OrbitRun
from proofmass.runner.analysis.linearisation.period_map import PeriodMap, UnrepeatedError
from proofmass.runner.analysis.linearisation.rings import Rings
from proofmass.runner.analysis.linearisation.seeds import NO_RINGS
from proofmass.runner.analysis.linearisation.waiting import Waiting, switch_note
from proofmass.runner.derivatives.dual_noise import changing, given
from proofmass.runner.host.arrays import Array, Complex
from proofmass.runner.plan.bindings import BufferBinding, StateBinding, Tick, Time, WireBinding
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan

SAME = 1e-9  # relative change of a map that counts as rounding
FROZEN, NOTED = 0.02, 1e-3  # largest accepted change of a loop in the time of its lowest crossover, and without a note
LONGEST_ORBIT, MOST_PERIODS = 10_000, 100  # base ticks and periods of a map over several periods
WAITED = 2  # least number of periods that a waiting switch stands still
_SETTLED_IN = 3.0  # time constants of a loop that a switch lets it be before it is told as before
_STRETCHES = 3  # of a run whose orbit does not come back
_LATER = 64  # periods by which a stretch may be longer, to end where the orbit is nearly back
_JUMPS = 16  # instants at which the map is compared
MOST_MAPS, MOST_COMPARED = 16, 2_000  # periods and base ticks of maps compared one by one
MOST_SWITCHED = MOST_VALUES  # periods of a map over those of a switch
_BACK = 0.1  # relative difference allowed between maps of noise over some periods and the next
STARTS_UP = 'tick 0 is a start-up, and the loop changes afterwards: use --at settled, or a time, such as --at "0.1 s"'
_TURNED_AT, _TURNED = 7, 1e-3  # instants of a turn; part by which what a parameter does may differ from one to another
_EXACTLY = 1e-9  # part of its swing, by which a number may miss its old value where orbits close


@dataclass(frozen=True)
class OrbitPoint:
    """The operating point of one map: over how many periods it is taken, and a remark about it."""

    map: PeriodMap
    periods: int
    notes: tuple[str, ...] = ()
    later: tuple[PeriodMap, ...] = ()
    others: tuple[PeriodMap, ...] = ()  # over stretches of the run, or at instants, that follow
    memory: Memory | None = None
    ticks: int = 0  # base ticks of the map, where it is about an orbit that was found to close
    integrated: bool = False
    rings: Rings = NO_RINGS

    @property
    def where(self) -> dict[str, Any]:
        """Options of `period_map`, with which other maps begin there."""
        return {"memory": self.memory, "span": self.ticks, "integrated": self.integrated, "rings": self.rings}

    @property
    def moves(self) -> bool:
        """True if a later period has another map, by more than rounding."""
        return any(change_between(self.map, after) > SAME for after in self.later)


class OrbitSearch:
    """Looks for the periods over which a map can be taken."""

    def __init__(self, plan: Plan, ends: Ends, onward: Onward, ahead: bool) -> None:
        """Take the run on from the operating point, which is the start of a period of the map.

        A loop that is open there may be looked for `ahead`, where it closes.
        """
        self._plan, self._ends, self._run = plan, ends, OrbitRun(plan, ends, onward)
        self._ticks, self._first, self._looks_ahead = self._run.ticks, self._run.first, ahead
        self._period = self._ticks * plan.period
        self._longest = min(LONGEST_ORBIT, MOST_VALUES * self._stride()) // self._ticks  # of periods of a map
        self._most = min(self._longest, MOST_PERIODS)
        self._compared = ComparedMaps(ends)
        self._repetitions = dict[int, list[int]]()  # by how many memories were known
        self._waiting = Waiting(onward, self._run.upstream, self._run.moving, self._ticks, ends.inputs, self._run.rings)

    def point(self) -> OrbitPoint:
        """Return the map with the memory that it starts from and the ticks that it covers; raises `ModelError`."""
        point = self._over_turns(self._point()) if self._ends.whole_turns else self._point()
        memory = self._run.memories[0]
        if point.map.tick != memory.tick:
            memory = self._run.later(memory, point.map.tick - memory.tick)
        return replace(point, memory=memory, ticks=point.periods * self._ticks, rings=self._run.rings)

    def _stride(self) -> int:
        """Return the base ticks between two values of the wires that are cut; of others no map is too long."""
        return min(map(self._plan.stride, self._ends.inputs)) if self._ends.cut else LONGEST_ORBIT

    def _point(self) -> OrbitPoint:
        """Return the map, over how many periods it is, and a remark about it."""
        first = self._run.map(0)
        open_here = self._ends.cut and not _passes(first)
        at_instants = self._at_instants(first) if open_here and self._looks_ahead else None
        if at_instants is not None:
            return at_instants
        horizon = self._horizon(first)
        changes = self._waiting.changes(self._run.after, horizon)
        changes = sorted({*changes, *(wraps - 1 for wraps in self._run.rings.wraps() if wraps > 1)})
        if not changes and self._waiting.stands() and not self._run.moves():
            return OrbitPoint(first, 1)
        apart = self._waiting.apart(horizon)
        if all(self._same(first, self._run.map(look)) for look in (1, *changes)) and all(
            self._compared.change(first, self._run.map(look)) <= NOTED for look in apart
        ):
            return OrbitPoint(first, 1, later=(self._run.map(1),))  # differs in last digits
        looks = {*(look for look in LOOKS if look == 1 or look * self._ticks <= MOST_COMPARED), *changes, *apart}
        maps = {look: self._run.map(look) for look in sorted(looks)}
        switched = [look for look in changes if look in maps and not self._same(first, maps[look])]
        closed = self._closed(first, (n for n in self._returns() if self._repeats(n, maps)), exactly=True)
        if closed is not None:
            return closed
        later = tuple(maps[look] for look in LOOKS if look in maps)
        change = self._change(first, maps, switched)
        if change > NOTED:
            closed = self._closed(first, self._returns_of_maps(first, maps), exactly=True)
        if closed is None and switched and (self._ends.noise or change > FROZEN):
            closed = self._closed(first, self._repetition())
        if closed is not None:
            return closed
        until = self._until(first, maps, switched)
        if change <= NOTED:
            return OrbitPoint(first, 1, until, later, self._ahead(first, maps, switched))
        if self._first == 0:
            return OrbitPoint(replace(first, starting=not until), 1, until or (STARTS_UP,), later)
        if change <= FROZEN:
            notes = (*until, *_moving(change))
            return OrbitPoint(first, 1, notes, later, self._ahead(first, maps, switched))
        orbit = self._orbit()
        closed = self._closed(first, (periods for periods in orbit.returns() if periods > 1))
        if closed is None and len(orbit.turning):
            closed = self._stretches(first)
        if closed is None:
            raise UnrepeatedError([self._plan.graph.placed(self._refused(orbit, first))])
        return closed

    def _over_turns(self, point: OrbitPoint) -> OrbitPoint:
        """Return the map over whole turns of all sources: what parameters do differs where periods are alike."""
        periods = math.lcm(point.periods, *self._repetition())
        if not point.periods < periods <= self._longest or (self._ends.cut and not self._turns(point, periods)):
            return point
        whole = replace(self._run.map(0, periods), starting=point.map.starting)
        return replace(point, map=whole, periods=periods, later=(self._run.map(periods, periods),))

    def _turns(self, point: OrbitPoint, periods: int) -> bool:
        """Return whether what parameters do to a loop turns with sources, whose own parameters move it or others do."""
        maps = periods // point.periods
        looks = {0, 1, 2, 3, *(maps * number // _TURNED_AT for number in range(1, _TURNED_AT))} & {*range(maps)}
        tables = list[dict[str, Array]]()
        for memory in (self._run.after(look * point.periods) for look in sorted(looks)):
            options: dict[str, Any] = {"span": point.periods * self._ticks, "rings": self._run.rings}
            moved = self._ends.map(self._plan, memory=memory, by_parameters=True, point_slopes={}, **options)
            tables.append({name: slope[:, :-1] for name, slope in moved.slopes.items() if slope[:, :-1].any()})
        first, sources = tables[0], turning(self._plan, self._ends)
        if any(table.keys() != first.keys() for table in tables) or any(split(name)[0] in sources for name in first):
            return True
        sizes = {name: SAME * np.abs(slope).max() for name, slope in first.items()}
        return not all(np.allclose(first[n], table[n], _TURNED, sizes[n]) for table in tables for n in first)

    def _ahead(self, first: PeriodMap, maps: Mapping[int, PeriodMap], switched: Sequence[int]) -> tuple[PeriodMap, ...]:
        """Return maps at instants ahead, if a loop that is closed has other limits there, taken as it stands."""
        if not self._ends.cut or switched or not _passes(first):
            return ()
        last = self._horizon(first)
        looks = sorted({max(1, last * number // INSTANTS) for number in range(1, INSTANTS + 1)})
        some = (*maps.values(), *(self._run.map(look) for look in looks[4::5]))
        return tuple(map(self._run.map, looks)) if moves_limits(first, some, FROZEN) else ()

    def _stretches(self, first: PeriodMap) -> OrbitPoint | None:
        """Return the map over a stretch of the run that the loop forgets itself in, and over those that follow.

        The orbit does not come back, as on a carrier that fits no number of periods; what a stretch
        does to small signals hardly depends on where it begins if it is long. At its limits a loop
        forgets nothing, so that a stretch ends where the orbit is nearest to where it began: else
        each repetition would turn the carrier by the rest.
        """
        periods = self._run.forgotten(first, self._longest)
        if periods < 2:
            return None
        most = min(max(periods + _LATER, min(2 * periods, FEW)), self._longest)
        periods = self._orbit(most=most).nearest(periods, most)  # it begins again nearly as it ends
        whole, *others = (self._run.map(number * periods, periods) for number in range(_STRETCHES))
        if not all(map(_passes, (whole, *others))):
            return None
        note = f"the orbit does not come back: taken over {_STRETCHES} stretches of {time_text(periods * self._period)}"
        return OrbitPoint(whole, periods, (note,), others=tuple(others))

    def _at_instants(self, first: PeriodMap) -> OrbitPoint | None:
        """Return the map from one instant at which the loop is closed to the next one, if it is open between."""
        code = self._run.course.machine_code(self._run.memories[0], LONGEST)
        looks = jumps(code, self._run.names) if code is not None and self._ticks == 1 else []
        closed = [look for look in looks[:_JUMPS] if not self._same(first, self._run.map(look))][:2]
        periods = closed[-1] - closed[0] if len(closed) > 1 else 0
        if not 1 < periods <= LONGEST_PERIOD:
            return None
        whole = self._run.map(closed[0] + 1, periods)  # with a new value, which is not looked for once more
        if not _passes(whole):
            return None
        after = self._run.map(whole.tick - self._first + periods, periods)  # its value is new too
        z = np.asarray(np.exp(1j * np.linspace(0.1, 1.0, 8) * math.pi))
        change = self._compared.effect(whole, after, z)
        if change > FROZEN:
            return None
        note = f"closed for an instant every {time_text(periods * self._period)}, and open between"
        return OrbitPoint(whole, periods, (note, *_moving(change)), (after,))

    def _drift(
        self,
        of_period: PeriodMap,
        later: Mapping[int, PeriodMap],
        periods: int,
        first: PeriodMap,
        following: PeriodMap,
    ) -> float:
        """Return the change between the maps `first` and `later` of a period, in the time of the lowest crossover.

        Between wires it is the time of the slowest pole of the map `of_period`, which a `following`
        one repeats. The change is what the fastest one adds up to in that time, unless that comes
        and goes: then it is no more than the largest, or what the one over the longest time adds up
        to.
        """
        crossovers = self._run.crossovers(of_period)
        crossed = 2.0 * math.pi * np.array(crossovers) * self._period
        z = np.asarray(np.exp(1j * crossed)) if crossovers else axis(periods)
        effects = {number: self._compared.effect(first, after, z) for number, after in later.items()}
        speeds = {number: changed / number for number, changed in effects.items()}  # a period

        def within(time: float) -> float:
            return min(time * max(speeds.values()), max(*effects.values(), time * speeds[max(speeds)]))

        if crossovers:
            return within(1.0 / (2.0 * math.pi * crossovers[0] * self._period))
        rates, rates_later = pole_rates(of_period), pole_rates(following)
        if len(rates) != len(rates_later):  # some state begins to move or comes to rest
            rates_later = rates
        # A pole that comes much nearer to neutral later, as the phase of an oscillation that settles, is neutral.
        slow = (rates > SAME) & ((rates >= NEAR) | (rates_later > 0.5 * rates))
        return within(periods / _slowest(rates[slow]))

    def _change(self, first: PeriodMap, maps: Mapping[int, PeriodMap], switched: Sequence[int]) -> float:
        """Return the drift of a period, and what a switch changes at once, if nothing has moved before it."""
        before = {look: of for look, of in maps.items() if look not in switched}
        if self._ends.cut or not switched or not all(self._same(first, of) for of in before.values()):
            return self._drift(first, maps, 1, first, maps[max(maps)])
        return max(self._compared.effect(first, maps[look], axis()) for look in switched)

    def _horizon(self, first: PeriodMap) -> int:
        """Return the number of periods within which a switch of the whole loop would matter."""
        longest = LONGEST_ORBIT // self._ticks
        return int(min(longest, 1.0 / (FROZEN * self._rate(first)))) if self._ends.cut else longest

    def _rate(self, first: PeriodMap) -> float:
        """Return by how much of its time constant, that of the lowest crossover, a loop comes on in a period."""
        crossovers = self._run.crossovers(first)
        return 2.0 * math.pi * crossovers[0] * self._period if crossovers else _slowest(pole_rates(first))

    def _repetition(self) -> list[int]:
        """Return the number of periods after which all switches do as before, if there is one."""
        if (known := len(self._run.memories)) not in self._repetitions:
            found = self._waiting.repetition(min(self._longest, MOST_SWITCHED), self._run.memories)
            self._repetitions[known] = [found] if found else []
        return self._repetitions[known]

    def _same(self, first: PeriodMap, after: PeriodMap) -> bool:
        return self._compared.change(first, after) <= SAME

    def _closed(self, first: PeriodMap, returns: Iterable[int], exactly: bool = False) -> OrbitPoint | None:
        """The map over periods after which the orbit closes but for slow motion, or `exactly`."""
        for periods in returns:
            closed = self._run.map(0, periods)
            after = self._run.map(periods, periods)
            if exactly and not self._same(closed, after):
                continue
            one_path = len(self._ends.inputs) == len(self._ends.outputs) == 1 and not self._ends.noise
            if exactly and one_path and same_between(first, closed, periods):  # as averages that begin anew each turn
                return OrbitPoint(first, 1)
            change = self._drift(closed, {periods: self._run.map(periods)}, periods, first, after)
            if self._ends.noise and self._compared.change(closed, after) > _BACK:
                continue
            if change <= FROZEN:
                once, whole = time_text(self._period), time_text(periods * self._period)
                note = f"linearised over {whole}, in which the orbit closes, not over the {once} of the schedule"
                return OrbitPoint(closed, periods, (note, *_moving(change)), (after,))
        return None

    def _returns(self) -> Iterator[int]:
        """Yield the numbers of periods after which rings, sources or numbers may be back."""
        turns = (1, *sorted({ring.turn for ring in self._run.rings.of.values()}), self._run.rings.turns())
        known = {1}
        for periods in (1, *self._repetition(), *self._orbit(paired=True).returns(_EXACTLY)):
            for turned in (math.lcm(periods, turn) for turn in turns):  # rings may begin anew at their own turns
                if turned not in known and turned <= self._longest:
                    known.add(turned)
                    yield turned

    def _returns_of_maps(self, first: PeriodMap, maps: Mapping[int, PeriodMap]) -> Iterator[int]:
        """Yield the numbers of periods after which the map is back."""
        most = min(MOST_MAPS, MOST_COMPARED // self._ticks)
        yield from (n for n in range(2, most + 1) if self._repeats(n, maps) and self._same(first, self._run.map(n)))

    def _repeats(self, periods: int, maps: Mapping[int, PeriodMap]) -> bool:
        """Return whether the maps of later periods are those of the first so many; what is known is asked first."""
        looks = sorted(maps, key=lambda look: (not self._run.knows(look % periods), look))
        return all(self._same(self._run.map(look % periods), maps[look]) for look in looks)

    def _orbit(self, paired: bool = False, most: int = 0) -> Orbit:
        return self._run.orbit(paired or bool(self._ends.noise), most or self._most)

    def _until(self, first: PeriodMap, maps: Mapping[int, PeriodMap], switched: Sequence[int]) -> tuple[str, ...]:
        """Return a remark about a switch that has waited, if it matters."""
        least = WAITED if self._ends.noise or not switched else max(WAITED, _SETTLED_IN / self._rate(first))
        for look in switched[:1]:
            if look > least and self._compared.change(first, maps[look]) > FROZEN:
                return (switch_note(look * self._period),)
        return ()

    def _refused(self, orbit: Orbit, found: PeriodMap) -> Problem:
        name, part, step = orbit.fastest() or self._run.slowest_ring()
        turning = any(True for _ in orbit.turning)
        crossed = ", ".join(f"{f:.3g} Hz" for f in self._run.crossovers(found)[:4])
        crossed = crossed and f", which would put crossovers at {crossed}"
        period, longest = time_text(self._period), time_text(self._most * self._period)
        return Problem(
            message=f"the operating point does not repeat in {period}, the period of the schedule",
            got=f"{part} changes by {step:.2g} of its swing from one period to the next{crossed}",
            expected=f"an orbit that closes in {period}, or in up to {longest}"
            if turning
            else "an operating point at rest",
            hint=f"take --at periodic if the loops have not settled yet; else choose rates so that a whole number of"
            f" carrier periods fits {period}, or model the loop at baseband"
            if turning
            else "take a later time; --at settled waits for loops, and for all blocks where there are none",
            path=("blocks", name),
        )


def turning(plan: Plan, ends: Ends) -> set[str]:
    """Return what may turn by itself: it changes and small signals do not reach it, or no wire moves its state."""
    upstream, moving = ends.blocks(plan)
    apart = changing(plan, (StateBinding, BufferBinding, Time, Tick)) - moving
    moved = {
        name
        for name in moving
        for role in {"update", "derivative"} & type(plan.blocks[name]).functions.keys()
        if any(isinstance(binding, WireBinding) for binding in plan.bindings(name, role))
    }
    return upstream & (apart | given(plan, (Time, Tick)) | (given(plan, (StateBinding,)) - moved))


def _passes(of_period: PeriodMap) -> bool:
    """Return whether something that goes in comes out."""
    between = of_period.between().parts()
    return bool(between[1].any() or between[3].any())


def _slowest(rates: Array) -> float:
    """Return the least rate of those that are not neutral, a period; 1 if there is none."""
    return float(np.min(rates, where=rates > SAME, initial=1.0))


def _moving(change: float) -> tuple[str, ...]:
    return (f"the operating point moves: the loop is wrong by some {100.0 * change:.1g} %",) if change > NOTED else ()


def axis(periods: int = 1) -> Complex:
    """Return points of the unit circle up to half the rate of some periods, close together at low frequencies."""
    return np.asarray(np.exp(1j * np.geomspace(1e-4, 0.9, 24) * math.pi / periods))
