"""The margins of loops over the phase to the schedule of an oscillation, where nothing holds it.

A carrier that fits the periods of a loop keeps the phase to them with which its run began. A sensor that is switched on
a moment later has another one: its loop samples the wave at other places. Runs that begin with the oscillator turned
on settle alike but for that.
"""

import math
from collections.abc import Collection
from dataclasses import replace
from functools import cache

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.loops import SETTLED
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Course, Onward
from proofmass.runner.analysis.linearisation.linearisation import Linearisation, OperatingPoints
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop, of_wires
from proofmass.runner.analysis.linearisation.orbit import FROZEN, OrbitPoint
from proofmass.runner.analysis.linearisation.orbit_run import OrbitRun
from proofmass.runner.analysis.linearisation.rings import Entry
from proofmass.runner.analysis.linearisation.seeds import NO_RINGS, held_in
from proofmass.runner.analysis.linearisation.settle import settled_tick
from proofmass.runner.analysis.linearisation.surroundings import Surroundings, moved
from proofmass.runner.analysis.margins.margins import Margins, margins_at, ranges, worst_of
from proofmass.runner.analysis.margins.side_by_side import amounts, kind_of, neutral_mode, open_loops
from proofmass.runner.plan.memory import start

PHASES = 8  # of a turn
_ALIKE = 1e-6  # part of L by which it is the same at another phase
_UNEVEN = 0.2  # of a step from phase to phase, by which one may be off that only began later


class OverPhases:
    """Notes on the ranges of margins over phases, of loops whose runs are begun once for all of them."""

    def __init__(self, points: OperatingPoints) -> None:
        self._points = points
        self._settled = dict[tuple[Entry, int, int], Linearisation | None]()  # by entry, period and phase
        self._worst = dict[Endpoint, dict[str, Linearisation]]()  # at the phase at which a figure is least

    def noted(self, found: Margins, node: Endpoint) -> Margins:
        """Return the margins of a loop, with a note where they are others at other phases of what oscillates."""
        system = found.system
        if not (found.hidden and found.stable and system.map.tick) or system.per_period > 1 or system.map.others:
            return found
        about, _ = self._points.about_loop(node)
        if about.at != SETTLED:
            return found
        ends = Ends((node,), (node,), cut=True)
        entry = _turning(about, about.point_of(ends), {name for mode in found.hidden for name in mode.blocks})
        try:
            told = entry and self._told(found, about, ends, entry)
        except ModelError:  # a run that begins with another phase does not settle
            return found
        if not (entry and told):
            return found
        worst = worst_of(told)
        places = {name: [row[name] for row in told].index(value) for name, value in worst.items()}
        self._worst[node] = {name: self._turned(about, entry, place, ends) for name, place in places.items()}
        stable = [row for row in told if row["gain_margin"] != -math.inf]
        text = ranges(stable) + "; unstable at some" * (len(stable) < len(told))
        note = f"over the phase of {entry[0]} to the schedule, which nothing holds: {text}"
        return replace(found, system=system.noted(note), elsewhere=worst)

    def at_worst(self, node: Endpoint, figure: str) -> OpenLoop | None:
        """Return a loop, with derivatives by parameters, at the phase at which a figure is worst; None without any."""
        phases = self._worst.get(node)
        return phases[figure].loop(node, by_parameters=True) if phases else None

    def _told(self, found: Margins, about: Linearisation, ends: Ends, entry: Entry) -> list[dict[str, float]] | None:
        """Return what a loop may require from phase to phase; None where it hardly changes. Raises `ModelError`."""

        @cache
        def loop(number: int) -> OpenLoop:
            onward = Onward(about.course, self._turned(about, entry, number, ends).memory())
            return of_wires(OrbitRun(about.plan, ends, onward).map(0), about.plan.period)

        def apart(first: int, second: int, by: float) -> bool:
            return loop(first).differs(loop(second), by)

        if not (apart(0, 1, FROZEN) or apart(0, 3, FROZEN)):
            return None
        if any(self._is_off(about, entry, n, ends) and margins_at(loop(n), "", "").stable for n in (1, 3)):
            return None  # something else holds it, as what vibrates from the start: no loop that grows moves it
        twice = not (apart(0, 4, _ALIKE) or apart(1, 5, _ALIKE))  # as a square, in a turn
        others = map(loop, range(1, PHASES // 2 if twice else PHASES))
        return [found.required(), *(_quickly(found, one) or margins_at(one, "", "").required() for one in others)]

    def _turned(self, about: Linearisation, entry: Entry, number: int, ends: Ends) -> Linearisation:
        """Return where a run settles that began so many parts of a turn on.

        One that does not settle so far on, as where the loop is unstable, is turned where that of
        the loop has settled. Raises `ModelError`.
        """
        begun = self._begun(about, entry, number, ends)
        if begun is not None and not self._is_off(about, entry, number, ends):
            return begun
        course, turn = about.course, {entry: number / PHASES}
        tick = about.tick - about.tick % ends.common_period(about.plan)
        own = Course(course.plan, course, begin=moved(course.at(tick), turn, NO_RINGS))
        return Linearisation(about.plan, own, tick, at=SETTLED)

    def _begun(self, about: Linearisation, entry: Entry, number: int, ends: Ends) -> Linearisation | None:
        """Return where a run settles that began so many parts of a turn on; None if it does not."""
        course, period = about.course, ends.common_period(about.plan)
        key = entry, period, number
        if key not in self._settled:
            own = Course(course.plan, course, begin=moved(start(course.plan), {entry: number / PHASES}, NO_RINGS))
            try:
                tick = settled_tick(own)
                self._settled[key] = Linearisation(about.plan, own, tick + -tick % period, at=SETTLED)
            except ModelError:
                self._settled[key] = None
        return self._settled[key]

    def _is_off(self, about: Linearisation, entry: Entry, number: int, ends: Ends) -> bool:
        """Return whether a run that settles does so at another phase than that with which it began."""
        first, there = (self._begun(about, entry, n, ends) for n in (0, number))
        if first is None or there is None:
            return False
        places = (float(held_in(of.memory(), entry, NO_RINGS)) for of in (there, first))
        return _off_turns(next(places) - next(places) - number / PHASES) > _UNEVEN / PHASES


def _turning(about: Linearisation, point: OrbitPoint, blocks: Collection[str]) -> Entry | None:
    """Return a number that some blocks remember whose whole turns change nothing; None if there is none.

    A part of a turn stays, but for what follows it.
    """
    memory, states = point.memory or about.memory(), point.map.states
    last = memory.tick + point.ticks
    near = Surroundings(states, memory, point.rings, lambda begin: about.course.from_memory(begin).to(last))
    for number, entry in enumerate(states):
        if entry[0] in blocks and type(held_in(memory, entry, point.rings)) is float:
            part = near.change({entry: 1.0 / PHASES})[number] - 1.0 / PHASES
            if _off_turns(part) <= _UNEVEN / PHASES and near.turns(entry, point.map.parts()[0]):
                return entry
    return None


def _off_turns(number: float) -> float:
    """Return how far a number is from whole turns."""
    return abs(number - round(number))


def _quickly(found: Margins, system: OpenLoop) -> dict[str, float] | None:
    """Return what a loop like another one may require in floating point, None if that is not sure."""
    loop, period = open_loops(system), system.map.period
    neutral = neutral_mode(loop) if len(system.map.states) > 1 else None
    if neutral is None:
        return None
    likely = amounts(loop, kind_of(loop, found, period, neutral))
    return likely.figures(0, period).required() if likely.certain[0] and likely.stable[0] else None
