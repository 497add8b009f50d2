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
from proofmass.runner.analysis.linearisation.linearisation import Linearisation, OperatingPoints, of_wires
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.orbit import FROZEN, OrbitPoint
from proofmass.runner.analysis.linearisation.orbit_run import OrbitRun
from proofmass.runner.analysis.linearisation.rings import Entry
from proofmass.runner.analysis.linearisation.seeds import NO_RINGS, held_in
from proofmass.runner.analysis.linearisation.settle import settled_tick
from proofmass.runner.analysis.linearisation.surroundings import Surroundings, moved
from proofmass.runner.analysis.margins.figures import least_gain_margin
from proofmass.runner.analysis.margins.margins import Margins, margins_at, ranges
from proofmass.runner.analysis.margins.side_by_side import amounts, kind_of, neutral_mode, open_loops
from proofmass.runner.plan.memory import start

PHASES = 8  # of a turn
_ALIKE = 1e-6  # part of L by which it is the same at another phase
_UNEVEN = 0.2  # of a step from phase to phase, by which one may be off that only began later


class OverPhases:
    """Notes on the ranges of margins over phases, of loops whose runs are begun once for all of them."""

    def __init__(self, points: OperatingPoints) -> None:
        self._points = points
        self._settled = dict[tuple[Entry, int, int], Linearisation]()  # by entry, period and phase
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
        gains, phases = told
        self._worst[node] = {
            figure: self._turned(about, entry, values.index(min(values)), ends)
            for figure, values in {"gain_margin": gains, "phase_margin": phases}.items()
        }
        stable = [pair for pair in zip(gains, phases, strict=True) if -math.inf not in pair]
        text = ranges(*zip(*stable, strict=True)) + "; unstable at some" * (len(stable) < len(gains))
        note = f"over the phase of {entry[0]} to the schedule, which nothing holds: {text}"
        return replace(found, system=system.noted(note), least_over_phases=(min(gains), min(phases)))

    def at_worst(self, node: Endpoint, figure: str) -> OpenLoop:
        """Return a loop that has a range, with derivatives by parameters, at the phase at which a figure is least."""
        return self._worst[node][figure].loop(node, by_parameters=True)

    def _told(
        self, found: Margins, about: Linearisation, ends: Ends, entry: Entry
    ) -> tuple[list[float], list[float]] | None:
        """Return gain and phase margins from phase to phase; None where they hardly change.

        They are minus infinity where the loop is unstable. Raises `ModelError`.
        """

        @cache
        def loop(number: int) -> OpenLoop:
            onward = Onward(about.course, self._turned(about, entry, number, ends).memory())
            return of_wires(OrbitRun(about.plan, ends, onward).map(0), about.plan.period)

        def place(number: int) -> float:
            return float(held_in(self._turned(about, entry, number, ends).memory(), entry, NO_RINGS))

        def apart(first: int, second: int, by: float) -> bool:
            return loop(first).differs(loop(second), by)

        if not (apart(0, 1, FROZEN) or apart(0, 3, FROZEN)):
            return None
        if any(_off_turns(place(number) - place(0) - number / PHASES) > _UNEVEN / PHASES for number in (1, 3)):
            return None  # something else holds it, as what vibrates from the start
        twice = not (apart(0, 4, _ALIKE) or apart(1, 5, _ALIKE))  # as a square, in a turn
        gains, phases = [found.least_gain_margin], [found.phase_margin or math.inf]
        for system in map(loop, range(1, PHASES // 2 if twice else PHASES)):
            gain, phase = _quickly(found, system) or _limits(margins_at(system, found.loop, found.open_at))
            gains, phases = [*gains, gain], [*phases, phase]
        return gains, phases

    def _turned(self, about: Linearisation, entry: Entry, number: int, ends: Ends) -> Linearisation:
        """Return where a run settles that began so many parts of a turn on.

        One that does not settle, as where the loop is unstable, is turned where that of the loop has
        settled. Raises `ModelError`.
        """
        course, period, turn = about.course, ends.common_period(about.plan), {entry: number / PHASES}
        key = entry, period, number
        if key not in self._settled:
            own = Course(course.plan, course, begin=moved(start(course.plan), turn, NO_RINGS))
            try:
                tick = settled_tick(own)
                tick += -tick % period
            except ModelError:
                tick = about.tick - about.tick % period
                own = Course(course.plan, course, begin=moved(course.at(tick), turn, NO_RINGS))
            self._settled[key] = Linearisation(about.plan, own, tick, at=SETTLED)
        return self._settled[key]


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


def _limits(found: Margins) -> tuple[float, float]:
    """Return gain and phase margin, minus infinity of a loop that is unstable."""
    return (found.least_gain_margin, found.phase_margin or math.inf) if found.stable else (-math.inf, -math.inf)


def _quickly(found: Margins, system: OpenLoop) -> tuple[float, float] | None:
    """Return the gain and phase margin of a loop like another one in floating point, None if they are not sure."""
    loop, turn = open_loops(system), 2.0 * math.pi * system.map.period
    neutral = neutral_mode(loop) if len(system.map.states) > 1 else None
    if neutral is None:
        return None
    left, _ = neutral.left_out(loop)
    crossovers = ([turn * f for f in each] for each in (found.gain_crossovers, found.phase_crossovers))
    figures = amounts(left, kind_of(left, *crossovers))
    if not (figures.certain[0] and figures.stable[0]):
        return None
    gain = least_gain_margin(float(figures.gain_margin[0]), float(figures.gain_reduction[0]))
    return gain, float(figures.phase_margin[0])
