"""Instants of an orbit that moves while a loop stands still for it: whether its gain margins move,
and where to look.

A loop that changes little in the time of its lowest gain crossover is taken as it stands. Where L
is negative, at higher frequencies, the same motion may change it much more. So it is with a carrier
that turns slowly against the ticks at which it is demodulated: what a step of the wire does at once
depends on the carrier's place.

Others are open but for instants: calibrations that count ticks, take a mean, and then set a
parameter. From instant to instant a counter goes on by the same step. Where it does not, the loop
may be closed for a tick.
"""

from collections.abc import Collection, Iterable
from typing import TYPE_CHECKING

import numpy as np

from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.host.arrays import Array, Complex
from proofmass.runner.plan.keys import StateField

if TYPE_CHECKING:
    from proofmass.runner.targets.native import CompiledLoop

INSTANTS = 16  # at which a loop is looked at that moves
_GRID = 900  # frequencies
LONGEST = 40_000  # base ticks in which two instants are looked for
_OFTEN = 0.125  # part of the ticks: what jumps more often, as a shift register, does not count


def moves_limits(first: PeriodMap, later: Iterable[PeriodMap], part: float) -> bool:
    """Return whether some later map has another L by more than a part of it where a factor is nearest its limit."""
    loop = OpenLoop(first.between())
    limits = _limits(loop)
    if loop.continuous or not len(limits):
        return False
    before = loop.response(limits)
    after = (OpenLoop(one.between()).response(limits) for one in later if one.states == first.states)
    return any(bool(np.max(np.abs(response - before) / np.abs(before)) > part) for response in after)


def _limits(loop: OpenLoop) -> Array:
    """Return the angular frequencies at which L is negative and nearest to -1 from either side, of a grid."""
    w = np.append(np.geomspace(1e-9, 0.999, _GRID), 1.0) * np.pi / loop.sample
    response: Complex = loop.response(w)
    negative = response.real < 0.0
    crossed = negative[:-1] & (np.sign(response.imag[:-1]) != np.sign(response.imag[1:]))
    places = [*np.flatnonzero(crossed), *([len(w) - 1] if negative[-1] else [])]
    sizes = {int(place): float(abs(response[place])) for place in places}
    inside = max((p for p in sizes if sizes[p] < 1.0), key=lambda p: sizes[p], default=None)
    outside = min((p for p in sizes if sizes[p] >= 1.0), key=lambda p: sizes[p], default=None)
    return np.asarray(w[[place for place in (inside, outside) if place is not None]])


def jumps(run: "CompiledLoop", blocks: Collection[str]) -> list[int]:
    """Return the ticks from now on in which a whole number in the states of some blocks does not count on as before."""
    counters = [
        key for key, kind in run.kinds() if isinstance(key, StateField) and kind is not float and key.block in blocks
    ]
    if not counters:
        return []
    steps = np.diff(run.numbers(counters, run.tick + LONGEST), axis=0)
    jumped = steps[1:] != steps[:-1]
    rare = jumped.mean(axis=0) <= _OFTEN
    return (1 + np.flatnonzero(jumped[:, rare].any(axis=1))).tolist()
