"""A loop over a box, tick by tick: each is a matrix that is a polynomial of the parameters, a
period their product.

    x[t+1] = (A_t + B_t F C_t) x[t],   closed by a factor F in each tick in which its wire has a value

Every number that lasts has a direction of its own before each tick. What one tick does to it is
known well, and polynomials keep it so: interpreted in balls, the ticks of a period would widen each
other.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from proofmass.runner.analysis.linearisation.rings import Entry, Rings
from proofmass.runner.analysis.linearisation.seeds import at_place, place_of, put
from proofmass.runner.analysis.linearisation.tick_maps import between
from proofmass.runner.derivatives.ball import UndecidedError
from proofmass.runner.derivatives.dual import SIGNALS, dual
from proofmass.runner.derivatives.dual_ticks import LastingPlace
from proofmass.runner.derivatives.polynomial import model_of
from proofmass.runner.derivatives.stepped_ticks import SteppedTicks
from proofmass.runner.derivatives.taylor_model import TaylorModel
from proofmass.runner.design.proof.ball_ticks import BallTicks, advanced
from proofmass.runner.design.proof.enclosed import Enclosed, quarters
from proofmass.runner.plan.memory import Memory

_Tick = tuple[TaylorModel, TaylorModel, TaylorModel]  # A, B and C: without a value of the wire B and C are zero
_TickRows = dict[tuple[LastingPlace | None, LastingPlace | None], Any]  # by what follows and from what; None: the wire


class SteppedBallTicks(BallTicks, SteppedTicks):
    """Ticks of balls, each with directions of its own."""

    @property
    def valued(self) -> list[int]:
        """The ticks in which the wire had a value."""
        return [tick for tick, had in enumerate(self._valued) if had]

    def rows(self) -> list[_TickRows]:
        """Return the slopes of each tick."""
        ticks: list[_TickRows] = [{} for _ in self._valued]
        for tick, row, column, slope in self._slopes:
            ticks[tick][row, column] = slope
        return ticks


@dataclass(frozen=True)
class TickProducts:
    """The ticks of a period of a loop, over a box."""

    kinds: Sequence[_Tick]  # those that differ
    order: Sequence[int]  # which of them each tick is
    size: int  # numbers that last
    starts: Sequence[int]  # places of the states before the period
    ends: Sequence[int]  # and after it
    valued: Sequence[int]  # ticks in which the wire has a value

    def opened(self, places: Sequence[int], values: Sequence[int]) -> Enclosed:
        """Return [A B; C D] of the open loop at the corners of some coordinates, for some of the wire's values."""
        n, valued = self.size, {self.valued[value] for value in values}
        kinds = [[Enclosed.at_corners(part, places) for part in tick] for tick in self.kinds]
        begin = np.eye(n)[:, self.starts]
        here = Enclosed.exact(np.broadcast_to(begin, (1 << len(places), *begin.shape)))
        rows = list[Enclosed]()
        for tick, kind in enumerate(self.order):
            a, b, c = kinds[kind]
            rows += [c @ here] * (tick in valued)
            here = Enclosed.joined([[a @ here, b]]) if tick in valued else a @ here
        width = here.middle.shape[-1]
        later = (Enclosed.exact(np.zeros((1 << len(places), 1, width - row.middle.shape[-1]))) for row in rows)
        below = [[Enclosed.joined([[row, rest]])] for row, rest in zip(rows, later, strict=True)]
        return Enclosed.joined([[here[self.ends, slice(None)]], *below])

    def closed(self, factor: TaylorModel, parts: int) -> TaylorModel:
        """Return the map of the states over a period, closed with a factor of so many parts."""
        ticks = [_closed(tick, factor, parts) for tick in self.kinds]
        rows, columns = (
            [place + part * self.size for part in range(parts) for place in of] for of in (self.ends, self.starts)
        )
        return _joined(ticks, tuple(self.order), {})[np.ix_(rows, columns)]


def _closed(tick: _Tick, factor: TaylorModel, parts: int) -> TaylorModel:
    a, b, c = (part.placed(lambda matrix: np.kron(np.eye(parts), matrix)) for part in tick)
    return a + b @ factor @ c if b.present and c.present else a


def _joined(
    ticks: Sequence[TaylorModel], order: tuple[int, ...], known: dict[tuple[int, ...], TaylorModel]
) -> TaylorModel:
    """Return the product of ticks, in halves that are powers of two, so that those alike are multiplied once."""
    if len(order) == 1:
        return ticks[order[0]]
    if order not in known:
        half = 1 << ((len(order) - 1).bit_length() - 1)
        later, earlier = (_joined(ticks, part, known) for part in (order[half:], order[:half]))
        known[order] = later @ earlier
    return known[order]


def tick_products(
    engine: SteppedBallTicks, begin: Mapping[Entry, LastingPlace], last: int, rings: Rings, states: Sequence[Entry]
) -> TickProducts:
    """Advance an engine, and return the ticks of its loop of some states, which begin in places of their own.

    Raises `UndecidedError` where a block decides differently within the box.
    """
    advanced(engine, last)
    ticks = engine.rows()
    end = {entry: place_of(engine.memory(), entry, rings) for entry in begin}
    found = {place for tick in ticks for pair in tick for place in pair if place}
    places = sorted(found | {*begin.values(), *end.values()}, key=repr)
    number, n = {place: i for i, place in enumerate(places)} | {None: len(places)}, len(places)
    links = np.zeros((n + 1, n + 1), dtype=bool)
    for row, column in (pair for tick in ticks for pair in tick):
        links[number[row], number[column]] = True
    for entry, place in begin.items():
        links[number[place], number[end[entry]]] = True
    if links[n, n]:
        raise UndecidedError("the wire follows itself within a tick")
    kept = between(links[:n, :n], links[:n, n], links[n, :n])
    kept += sorted({number[of[entry]] for of in (begin, end) for entry in states} - {*kept})
    keys = [*(places[i] for i in kept), None]
    kinds, order = dict[Any, tuple[int, _Tick]](), list[int]()
    for tick in ticks:
        rows = [[tick.get((row, column), 0.0) for column in keys] for row in keys]
        tick_parts = _parts(rows)
        name = tuple(part.name for part in tick_parts)
        order.append(kinds.setdefault(name, (len(kinds), tick_parts))[0])
    where = {place: i for i, place in enumerate(keys)}
    starts, ends = ([where[of[entry]] for entry in states] for of in (begin, end))
    return TickProducts([of for _, of in kinds.values()], order, len(kept), starts, ends, engine.valued)


def _parts(rows: Sequence[Sequence[Any]]) -> _Tick:
    a, b, c, _ = quarters(model_of(rows), len(rows) - 1)
    return a, b, c


def seeded(memory: Memory, entries: Sequence[Entry], rings: Rings) -> dict[Entry, LastingPlace]:
    """Give numbers of a memory directions of their own, and return their places."""
    places = {entry: place_of(memory, entry, rings) for entry in entries}
    for entry, place in places.items():
        put(memory, place, at_place(memory, place) + dual(0.0, {entry: 1.0}, SIGNALS))
    return places
