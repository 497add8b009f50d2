"""From one tick to the next: steps of any method, their length chosen by their error, and events in between.

Plain Python runs these functions on lists, the compiled loop on arrays, both to the same bits. What
they are given: `step(context, time, length, x, moved, error)` writes the states one step later and
an estimate of their error; `clearances(context, time, x, clear)` writes what is above zero as long
as nothing happens; behind the `events` the numbers whose signs tell on which side of each corner
the group is; and, from `counts` on, how many corners a source has passed. `then(context, time, x,
which)` changes the states when an event happens. Nothing happens at a corner but that a step ends
there, and the next begins beyond it.
"""

from typing import Any, NamedTuple

from proofmass.blocks.arithmetic.elementary import exponential, logarithm_of_fraction
from proofmass.runner.continuous.linear_equations import Flat

MOST_EVENTS = 10_000  # in one tick
CHATTER = 500  # events, and again in at least half the time: rebounds slow down
MOST_CORNERS = 1_000  # that equal steps end at
MOST_SHORT, SHORT = 1_000, 1e-6  # steps one after the other, each shorter than that part of a tick
SHORTEST = 1e-12  # step, in ticks
DONE = 0.0  # what `integrate` returns where all went well
STEPS_TOO_SHORT = -1.0  # no step is short enough
STEPS_TOO_MANY = -2.0
SAFETY, LEAST, MOST = 0.9, 0.2, 5.0  # of the next step's length, in this one's
NEARLY = 1.0 - 1e-9
TINY = 1e-300
UNWATCHED = -2.0  # in place of the side of a corner
NEAR = 1e-3  # of the first step: at a jump that is so near, and moves with the states, steps no longer get shorter
YOUNG = 1e-3  # part of its largest value that a state had at most before it left rest


class GroupTick(NamedTuple):
    """A group in a tick: the functions above, the time, the accuracy that is wanted, and sequences to work in."""

    step: Any
    clearances: Any
    then: Any
    context: Any
    start: float
    period: float
    first: float  # step
    tolerance: float
    order: int
    precision: float
    x: Flat
    moved: Flat
    error: Flat
    largest: Flat
    begun: Flat
    clear: Flat
    side: Flat
    events: int
    counts: int


def integrate(tick: GroupTick) -> float:
    """Move the states `x` by a period, in steps of `first` seconds, or from there on as long as a
    tolerance allows.

    A tolerance of zero means steps as long as the first, shorter ones only where no number comes
    out of it. Errors are relative to the `largest` value that a state ever had, which is kept
    there. What leaves rest in this tick has no such value yet: then the tick is passed once to find
    it, and again from where it `begun`. Events are found to within `precision` seconds. Returns
    `DONE`, `STEPS_TOO_SHORT`, `STEPS_TOO_MANY`; the number, from 1, of an event that happens again
    and again at one instant; or that of an event or corner too many, after all these.
    """
    x, begun = tick.x, tick.begun
    for i in range(len(x)):
        begun[i] = x[i]
        begun[len(x) + i] = max(tick.largest[i], abs(x[i]))
    status, from_rest, young = DONE, True, 1.0
    while status == DONE and from_rest and young > 0.1 * YOUNG:
        for i in range(len(x)):
            x[i] = begun[i]
        status, from_rest = _passed(tick, young)
        young *= YOUNG
    return status


def _passed(tick: GroupTick, young: float) -> tuple[float, bool]:
    """Return what `integrate` does, and whether an error was small for what is ahead."""
    start, period, first, tolerance, events = tick.start, tick.period, tick.first, tick.tolerance, tick.events
    x, moved = tick.x, tick.moved
    done, size, corners, short, event, corner, from_rest = 0.0, first, 0, 0, -1, -1, False
    happened, earliest, middle = 0, 0.0, 0.0
    allowed = _settled(tick, start, MOST_EVENTS)
    while done < period and allowed > 0:
        left = period - done
        length = left if size >= left * NEARLY else size
        tick.step(tick.context, start + done, length, x, moved, tick.error)
        if tolerance > 0.0:
            worst = _largest_error(tick, first / length, young) / tolerance
            size = length * _growth(worst, tick.order)
            jumped = False
            if not worst <= 1.0 and _is_finite(moved):  # by a jump? Then the step up to it decides
                event = _due(tick, start + done + length, moved)
                jumped = event >= tick.counts or (event >= events and length < NEAR * first)
            if size < period * SHORTEST and not jumped and not (worst <= 1.0 and length == left):
                return STEPS_TOO_SHORT, False
            if not worst <= 1.0 and not jumped:
                continue
            if not jumped and not _largest_error(tick, 0.0, young) <= tolerance:
                from_rest = True
        elif not _is_finite(moved):  # beyond the end of physics; an event may lie before
            size = 0.5 * length
            if size < period * SHORTEST:
                return STEPS_TOO_SHORT, False
            continue
        else:
            size = first
        event = _due(tick, start + done + length, moved)
        if event >= 0:
            before, length, event = _located(tick, start + done, length, event)
            size = min(size, first)
            if event >= events and before > 0.0:
                tick.step(tick.context, start + done, before, x, moved, tick.error)
                worst = _largest_error(tick, first / before, young)
                if tolerance > 0.0 and not worst <= tolerance and before > period * SHORTEST:
                    size = 0.5 * before  # a stage lay beyond the jump
                    continue
                for i in range(len(x)):
                    x[i] = moved[i]
            else:
                before = 0.0
            _moved(tick, start + done + before, length - before)
        for i in range(len(x)):
            x[i] = moved[i]
            tick.largest[i] = max(tick.largest[i], abs(x[i]))
        done = period if length == left else done + length
        if 0 <= event < events:
            tick.then(tick.context, start + done, x, event)
            allowed -= 1
            happened += 1
            earliest = done if happened == 1 else earliest
            middle = done if happened == CHATTER else middle
            pace = (done - middle) / CHATTER
            steady = happened == 2 * CHATTER and done - middle >= 0.5 * (middle - earliest)
            if steady and period - done > MOST_EVENTS * pace:
                return 1.0 + len(tick.clear) + event, False
        allowed = _settled(tick, start + done, allowed)
        corners += 1 if event >= events else 0
        if tolerance == 0.0 and corners > MOST_CORNERS:  # motion along a jump never ends
            for i in range(len(tick.side)):
                tick.side[i] = UNWATCHED
        short = short + 1 if length < period * SHORT and not 0 <= event < events else 0
        corner = event if event >= events else corner if short > 0 else -1
        if tolerance > 0.0 and short > MOST_SHORT:
            return (1.0 + len(tick.clear) + corner if corner >= 0 else STEPS_TOO_MANY), False
    if allowed == 0:
        due = _due(tick, start + done, x)
        return (1.0 + due if due >= 0 else 1.0 + len(tick.clear) + max(0, event)), False
    return DONE, from_rest


def _largest_error(tick: GroupTick, reach: float, young: float) -> float:
    """Return the largest error of a state, relative to the largest value that it ever had; NaN if
    one is not finite.

    A state that leaves rest may grow with a high power of the time, so that no step is short enough
    for what it is at the end of it: while it is less than the part `young` of what its rate makes
    of a first step, `reach` times as long, its error is relative to that, and once more.
    """
    x, moved, largest = tick.x, tick.moved, tick.largest
    worst, broken = 0.0, 0.0
    for i in range(len(moved)):
        scale, change = max(largest[i], abs(moved[i])), reach * abs(moved[i] - x[i])
        if largest[i] <= young * change and tick.begun[len(x) + i] <= YOUNG * scale:
            scale = max(scale, reach * change)
        ratio = abs(tick.error[i]) / (scale + TINY)
        worst = max(worst, ratio)
        broken += ratio - ratio
    return worst + broken


def _is_finite(x: Flat) -> bool:
    """Return whether all states are finite."""
    broken = 0.0
    for i in range(len(x)):
        broken += x[i] - x[i]
    return broken == 0.0


def _growth(worst: float, order: int) -> float:
    """Length of the next step in this one's, from the error of this one in tolerances."""
    if not worst < 1e10:
        return LEAST
    if worst < 1e-10:
        return MOST
    logarithm = logarithm_of_fraction(worst) if worst <= 1.0 else -logarithm_of_fraction(1.0 / worst)
    return min(MOST, max(LEAST, SAFETY * exponential(-logarithm / order)))


def _due(tick: GroupTick, time: float, x: Flat) -> int:
    """The first event whose clearance is used up, or corner that is reached, where the next side may begin; or -1."""
    clear, side = tick.clear, tick.side
    if len(clear) > 0:
        tick.clearances(tick.context, time, x, clear)
        for i in range(len(clear)):
            if i < tick.events:
                reached = clear[i] <= 0.0
            elif i < tick.counts:
                reached = side[i] > UNWATCHED and clear[i] * side[i] <= 0.0
            else:
                reached = side[i] > UNWATCHED and clear[i] != side[i]
            if reached:
                return i
    return -1


def _settled(tick: GroupTick, time: float, allowed: int) -> int:
    """Let everything happen that is due, and note on which side each corner is; how many events are
    still allowed in this tick."""
    clear, side = tick.clear, tick.side
    for i in range(len(side)):
        side[i] = UNWATCHED
    due = _due(tick, time, tick.x)
    while due >= 0 and allowed > 0:
        tick.then(tick.context, time, tick.x, due)
        allowed -= 1
        due = _due(tick, time, tick.x)
    for i in range(tick.events, len(clear)):
        side[i] = clear[i] if i >= tick.counts else 1.0 if clear[i] > 0.0 else -1.0 if clear[i] < 0.0 else UNWATCHED
    return allowed


def _moved(tick: GroupTick, time: float, length: float) -> None:
    """A step that may have no length."""
    if length > 0.0:
        tick.step(tick.context, time, length, tick.x, tick.moved, tick.error)
    else:
        for i in range(len(tick.x)):
            tick.moved[i] = tick.x[i]


def _located(tick: GroupTick, time: float, length: float, event: int) -> tuple[float, float, int]:
    """The lengths of a step that ends before the first event or corner in it and of one that ends
    at it or beyond, and which one that is; `event` is due at the end of `length`.

    Bisection finds the event to within `precision`; where its clearance is a straight line there,
    what is left is taken off too, since whatever an event comes late stays in the motion that
    follows.
    """
    clear, moved = tick.clear, tick.moved
    before, after, used = 0.0, length, clear[event]
    for _ in range(1100):
        middle = 0.5 * (before + after)
        if not (after - before > tick.precision and before < middle < after):
            break
        tick.step(tick.context, time, middle, tick.x, moved, tick.error)
        found = _due(tick, time + middle, moved)
        if found >= 0:
            after, event, used = middle, found, clear[found]
        else:
            before = middle
    if event >= tick.events:
        return before, after, event
    _moved(tick, time, before)
    tick.clearances(tick.context, time + before, moved, clear)
    share = clear[event] / (clear[event] - used) if clear[event] > 0.0 else 1.0
    return before, before + share * (after - before), event
