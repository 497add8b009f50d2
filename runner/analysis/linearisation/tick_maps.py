"""A loop that is cut at one wire, from one value of the wire to the next: a product of small maps
for each period.

    y[k] = c[k] x[k] + d[k] u[k],   x[k+1] = a[k] x[k] + b[k] u[k],   k = 0 ... p - 1,   x[p] is the next x[0]

Closed through a factor f, u = f y, one period is the product of a[k] + b[k] c[k] f / (1 - f d[k]).
Those of several factors are computed side by side, value by value. Each has its own power of two,
so that a loop which grows by any factor and shrinks again is exact.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.linalg

from proofmass.runner.analysis.linearisation.rings import Entry
from proofmass.runner.analysis.linearisation.tick_products import held, joined, lifted, products, repeated
from proofmass.runner.derivatives.dual_ticks import LastingPlace
from proofmass.runner.derivatives.stepped_ticks import TickSlopes
from proofmass.runner.host.arrays import Array, Truths

_ENTRIES = 1 << 20  # numbers of a batch
_ROOM = 500.0  # powers of two by which products may grow before they are scaled
_UNSCALED = 8  # values of the wire for which they are not scaled at most
_MOST_ENTRIES = 1 << 25  # of all maps: 256 MiB
_DOUBLED = 40  # times that the number of periods is doubled over which a sum is taken
_GROWN = 1e30  # size of a period's map that is not that of a stable loop any more
_eig: Any = scipy.linalg.eig


@dataclass(frozen=True)
class TickMaps:
    """The maps of one period, and the places in x of the states the period begins and ends with."""

    a: Array  # p x n x n
    b: Array  # p x n
    c: Array  # p x n
    d: Array  # p
    places: Mapping[Entry, int]

    def closed(self, states: Sequence[Entry], factor: complex = 1.0) -> npt.NDArray[Any]:
        """Return the transition matrix of some states over a period, closed through a factor."""
        (product,), (exponent,) = self._batches(np.array([factor]))
        places = [self.places[state] for state in states]
        return np.asarray(product[np.ix_(places, places)] * np.ldexp(1.0, exponent))

    def fed_back(self) -> "TickMaps":
        """Return the maps from what is added at the wire to its values, with the loop closed."""
        inverse = 1.0 / (1.0 - self.d)
        b, c = self.b * inverse[:, None], self.c * inverse[:, None]
        return TickMaps(self.a + self.b[:, :, None] * c[:, None, :], b, c, self.d * inverse, self.places)

    def growths(self, factors: npt.NDArray[Any], hidden: Sequence[complex] = ()) -> Array:
        """Return by how much the slowest mode grows in a period for each factor, as a logarithm.

        Poles that no factor moves are left out if they are `hidden`.
        """
        whole, exponents = self._batches(factors)
        known = np.flatnonzero(np.isfinite(whole).all(axis=(1, 2)))
        poles = [
            others(values, [pole * 2.0 ** -float(power) for pole in hidden])
            for values, power in zip(np.linalg.eigvals(whole[known]), exponents[known], strict=True)
        ]
        grown = np.full(len(factors), np.inf)
        with np.errstate(divide="ignore"):
            grown[known] = np.log([np.max(np.abs(values), initial=0.0) for values in poles])
        return np.asarray(grown + exponents * np.log(2.0))

    def _batches(self, factors: npt.NDArray[Any]) -> tuple[npt.NDArray[Any], npt.NDArray[np.int64]]:
        """Return the transition matrix of x over a period for each factor, and the power of two that it lacks."""
        step = max(1, _ENTRIES // max(1, self.b.shape[1] ** 2))
        loops = factors[:, None] / (1.0 - factors[:, None] * self.d)
        steps = self._unscaled(loops)
        parts = (products(self.a, self.b, self.c, loops[i : i + step], steps) for i in range(0, len(loops), step))
        matrices, exponents = zip(*parts, strict=True)
        return np.concatenate(matrices), np.concatenate(exponents)

    def _unscaled(self, loops: npt.NDArray[Any]) -> int:
        """Return for how many values of the wire no product can leave the range of numbers."""
        moved, back = self._growing
        largest = float(np.max(moved + np.max(np.abs(loops), axis=0) * back, initial=1.0))
        return min(_UNSCALED, max(1, int(_ROOM / np.log2(largest)))) if 2.0 < largest < np.inf else _UNSCALED

    @cached_property
    def _growing(self) -> tuple[Array, Array]:
        """Bounds of what each map makes of a state, without the wire and by it."""
        entered, read = (np.sum(np.abs(part), axis=1) for part in (self.b, self.c))
        return np.sum(np.abs(self.a), axis=(1, 2)), entered * read

    @cached_property
    def units(self) -> Array:
        """Units of the states that a period of a stable closed loop begins with, in which all inputs
        ever stir them as much as all outputs show them.
        """
        closed = self.fed_back()
        b, c = closed.b, closed.c
        g, h = b[:, :, None] * b[:, None, :], c[:, :, None] * c[:, None, :]
        period, entered, read = self._of_period(_added, closed.a, g, h)
        stirred, shown = np.diag(_lasting(period, entered)), np.diag(_lasting(period.T, read))
        unit = np.divide(stirred, shown, out=np.ones(len(period)), where=(stirred > 0.0) & (shown > 0.0))
        return np.asarray(np.exp2(np.round(0.25 * np.log2(unit))))

    def crossed(self, level: float, offset: float, near: float, hidden: Sequence[complex] = ()) -> list[float]:
        """Return the angles of exp(j w T) at which a singular value of offset - T is at a level
        above the offset.

        What is `near` the unit circle counts as on it, but for the `hidden` poles there, which are
        there at any level.

        They are the eigenvalues on the unit circle of the symplectic pencil of the period, composed
        of those of its values as waves pass layers one after the other (Anderson, Int. J. Control
        28, 1978, 295).
        """
        closed = self.fed_back()
        b, c, d = closed.b, closed.c, offset + closed.d
        rest = level**2 - d**2
        a = closed.a + (d / rest)[:, None, None] * b[:, :, None] * c[:, None, :]
        g = b[:, :, None] * b[:, None, :] / rest[:, None, None]
        h = (1.0 + d**2 / rest)[:, None, None] * c[:, :, None] * c[:, None, :]
        values = _symplectic_poles(*self._of_period(_composed, a, g, h), self.units)
        values = others(values, [*hidden, *(1.0 / pole.conjugate() for pole in hidden)])
        on_circle = values[np.abs(np.abs(values) - 1.0) <= near]
        return sorted(float(angle) for angle in np.angle(on_circle))

    def _of_period(self, pair: Callable[..., tuple[Array, ...]], *parts: Array) -> tuple[Array, Array, Array]:
        """Return what a period makes of its states, by what each `pair` of values makes of all parts, again and again.

        What else there is in x begins each period at zero.
        """
        while (count := len(parts[0])) > 1:
            last = count - count % 2
            made = pair(*(part[begin:last:2] for begin in (0, 1) for part in parts))
            parts = tuple(map(np.concatenate, zip(made, (part[last:] for part in parts), strict=True)))
        kept = np.ix_(*[list(self.places.values())] * 2)
        a, g, h = (part[0][kept] for part in parts)
        return a, g, h

    def holds(self) -> tuple[int, int]:
        """Return after how many values the wire has a new one, and how many values it holds each
        for; 1 if any other.
        """
        ticks, alike = len(self.d), repeated(self.a, self.b, self.c)
        new = 1 + np.flatnonzero(~alike | (self.d[1:] != 0.0) | (self.d[:-1] != 0.0))
        for starts in filter(len, (np.append(0, new), new)):
            first, each = int(starts[0]), ticks // len(starts)
            if np.array_equal(starts, first + each * np.arange(ticks // each)):
                return first, each
        return 0, 1

    def held(self, each: int) -> "TickMaps":
        """Return the maps from one new value of the wire to the next, each held for so many."""
        return TickMaps(*held(self.a, self.b, each), self.c[::each], self.d[::each], self.places)

    def lifted(self, states: Sequence[Entry]) -> Array:
        """Return [A B] and below it [C D] of the period, for some states and all wire values."""
        ticks, n = self.b.shape
        moved, read = lifted(self.a, self.b, self.c, self.d)
        kept = [self.places[state] for state in states]
        return np.vstack([moved[kept], read])[:, [*kept, *range(n, n + ticks)]]


def maps_of_ticks(
    slopes: TickSlopes, starts: Mapping[Entry, LastingPlace], ends: Mapping[Entry, LastingPlace]
) -> TickMaps | None:
    """Return the maps of a period, of what lies between the input and the output; None if they are too large.

    `starts` and `ends` are the places of the states before and after the period.
    """
    size, number = len(slopes.places), {place: i for i, place in enumerate(slopes.places)}
    back = {entry: (number[starts[entry]], number[ends[entry]]) for entry in starts.keys() & ends.keys()}
    every = size + slopes.wires
    wire, others = size + slopes.opened, [size + n for n in range(slopes.wires) if n != slopes.opened]
    edges = np.zeros((every, every), dtype=bool)
    edges[slopes.row, slopes.column] = True
    for to, source in back.values():
        edges[to, source] = True
    inside = [*range(size), *others]
    found = between(edges[np.ix_(inside, inside)], edges[inside, wire], edges[wire, inside])
    kept = [place for place in found if place < size]
    n, values = len(kept), int(slopes.valued.sum())
    if values * n * n > _MOST_ENTRIES:
        return None
    within = np.full(every, -1)
    within[[*kept, wire, *others]] = np.arange(n + slopes.wires)
    row, column = within[slopes.row], within[slopes.column]
    counts = (row >= 0) & (column >= 0)
    again = within[np.array([*back.values()], dtype=np.int64).reshape(-1, 2)]
    again = again[(again >= 0).all(axis=1)]
    last = len(slopes.valued)  # where the end of a period is the start of the next
    tick = np.append(slopes.tick[counts], np.full(len(again), last))
    value = np.append(slopes.value[counts], np.ones(len(again)))
    row, column = (np.append(of[counts], again[:, i]) for i, of in enumerate((row, column)))
    entries = ((entry, int(within[number[place]])) for entry, place in starts.items() if place in number)
    places = {entry: place for entry, place in entries if place >= 0}
    valued = np.append(slopes.valued, False)
    return TickMaps(*joined(n, len(others), valued, tick, row, column, value), places)


def between(acts: Truths, entered: Truths, read: Truths) -> list[int]:
    """Return the states that inputs reach and that reach outputs, where row i of `acts` follows from column j."""
    return np.flatnonzero(reached(acts.T, entered) & reached(acts, read)).tolist()


def reached(acts: Truths, begin: Truths) -> Truths:
    """Return which states are reached from those of the start, where row i leads to column j."""
    every = new = begin
    while new.any():
        new = acts[new].any(axis=0) & ~every
        every = every | new
    return every


def maps_of_lifted(states: Sequence[Entry], a: Array, b: Array, c: Array, d: Array) -> TickMaps:
    """Return maps with the transfer of a period. They keep x, its next value, outputs to come."""
    n, ticks = len(a), len(d)
    size = 2 * n + ticks
    moved = np.tile(np.eye(size), (ticks, 1, 1))
    entered, read = np.zeros((ticks, size)), np.zeros((ticks, size))
    entered[:, n : 2 * n] = b.T
    for k in range(ticks):
        read[k, :n], read[k, 2 * n + k] = c[k], 1.0
        entered[k, 2 * n + k + 1 :] = d[k + 1 :, k]
    last = np.zeros((size, size))
    last[:n, :n], last[:n, n : 2 * n] = a, np.eye(n)
    moved[-1] = last @ moved[-1]
    entered[-1] = last @ entered[-1]
    return TickMaps(moved, entered, read, np.diag(d).copy(), {state: i for i, state in enumerate(states)})


def _composed(a1: Array, g1: Array, h1: Array, a2: Array, g2: Array, h2: Array) -> tuple[Array, Array, Array]:
    """Return the maps of pairs: x' = a x + g l', l = a^T l' + h x of the first, then of the second."""
    n = a1.shape[1]
    through = np.linalg.solve(np.eye(n) - g1 @ h2, np.concatenate([a1, g1 @ np.swapaxes(a2, 1, 2)], axis=2))
    ahead, back = through[:, :, :n], through[:, :, n:]
    return a2 @ ahead, g2 + a2 @ back, h1 + np.swapaxes(a1, 1, 2) @ h2 @ ahead


def _added(a1: Array, g1: Array, h1: Array, a2: Array, g2: Array, h2: Array) -> tuple[Array, Array, Array]:
    """Return what pairs of maps move, what enters them and what they show, the first's before the second's."""
    return a2 @ a1, g2 + a2 @ g1 @ np.swapaxes(a2, 1, 2), h1 + np.swapaxes(a1, 1, 2) @ h2 @ a1


def _symplectic_poles(a: Array, g: Array, h: Array, unit: Array) -> npt.NDArray[Any]:
    """Return z of z x = a x + g z l, l = a^T z l + h x, in units of x in which waves of both kinds are alike."""
    a, g, h = a * unit / unit[:, None], g / unit / unit[:, None], h * unit * unit[:, None]
    eye, zero = np.eye(len(a)), np.zeros(a.shape)
    now, later = np.block([[a, zero], [-h, eye]]), np.block([[eye, -g], [zero, a.T]])
    return np.asarray(_eig(now, later, right=False))


def _lasting(closed: Array, entered: Array) -> Array:
    """Return about the sum of what enters in all periods, which a stable loop forgets but for rounding."""
    for _ in range(_DOUBLED):
        if np.max(np.abs(closed), initial=0.0) > _GROWN:
            break
        entered, closed = entered + closed @ entered @ closed.T, closed @ closed
    return entered


def others(values: npt.NDArray[Any], hidden: Sequence[complex]) -> npt.NDArray[Any]:
    """Return the eigenvalues without those that are nearest to hidden ones."""
    if not hidden:
        return values
    left = list(values)
    for pole in hidden:
        left.remove(min(left, key=lambda value: abs(value - pole)))
    return np.array(left)
