"""Places: where numbers are that come to no rest of their own, as the phase of an oscillation.

Where a period of a sensor moves a number p on and leaves all others x as they are but for what
moves with it, x is a curve of p:

    F(x(p), p) = x(p) + T d,   p + d = F_p(x(p), p),   T = dx/dp

A proof is about all its places p, as it is about all parameters. About one of them distances y
from the curve move by

    y[n+1] = (J_x - T P_x) y[n],   J_x T + J_p = T (P_x T + P_p)

with the slopes J and P of x and p: after each period all is moved back along the curve to where p was.
The poles are those of the whole but for that of p, which is one (Guckenheimer and Holmes, Nonlinear
Oscillations, section 1.5). With T within E of a guess,

    |R (H + J_x E - T P_x E - E (P_x T + P_p) - E P_x E) + E| <= |E|,   H = J_x T + J_p - T (P_x T + P_p)

shows that there is such a T: R is that of the point of rest, which is regular. The place moves by d
in a period: either slowly, so that it is one as good as at rest, or nothing follows it.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg

from proofmass.runner.analysis.linearisation.rings import Entry
from proofmass.runner.analysis.linearisation.seeds import held_in
from proofmass.runner.analysis.linearisation.surroundings import Surroundings, moved
from proofmass.runner.derivatives.ball import UndecidedError, arb_of, double_of
from proofmass.runner.derivatives.dual import plain, with_plain
from proofmass.runner.derivatives.polynomial import PolynomialBall, Turned, model_of
from proofmass.runner.derivatives.taylor_model import TaylorModel
from proofmass.runner.design.proof.enclosed import quarters
from proofmass.runner.design.worst.ranges import Range
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.memory import Memory

_UNKNOWN = "how sensors move with their places is not known"
_NEUTRAL = 1e-7  # distance from one of the pole of a place
_ALIKE = 1e-6  # part of a map by which it is the same at another place
_TRIED = 1e-3  # part of a number, to another place of one that is where it started
_SLOW = 1e-5  # of a turn, or in the unit of the place: so far it moves in a period while the sensor stays about it
_STEPS, _WIDENED, _ROOM = 8, 30, 1.5  # of curves, of what is unknown of them, and how much further than needed it is
_UP, _LEAST = 1.0 + 1e-12, 1e-60  # more than the rounding of sums, and beside zero


@dataclass(frozen=True)
class NeutralPlace:
    """A number of what is remembered that comes to no rest of its own, and all that it may be."""

    entry: Entry
    nominal: float  # as the run has it
    low: float
    high: float
    turns: bool = False  # what follows it comes round with each turn of it
    alone: bool = False  # nothing follows it

    @property
    def range(self) -> Range:
        """Its range, as that of a parameter."""
        name = f"{self.entry[0]}:{self.entry[1]}"
        return Range(name, name, "", min(max(self.nominal, self.low), self.high), self.low, self.high)

    @property
    def name(self) -> str:
        """Its name, that of no parameter."""
        return self.range.name

    def check(self, moved: float) -> None:
        """Raise `UndecidedError` where it moves so far in a period, and not slowly, though numbers follow it."""
        if not self.alone and not moved <= _SLOW:
            raise UndecidedError(f"{self.name} moves on, and what is remembered follows it")

    def passed(self, moved: Any) -> Any:
        """Return how far it has moved, but for whole turns."""
        value = plain(moved)
        if isinstance(value, Turned):
            value = value.of
        return with_plain(moved, value - float(round(double_of(value)[0]))) if self.turns else moved


@dataclass(frozen=True)
class Around(Surroundings):
    """Surroundings of a memory, that of the start of its run, and the map of a period from other memories."""

    begun: Memory
    mapped: Callable[[Memory], Array]

    def place(self, entry: Entry, along: Mapping[Entry, float]) -> tuple[NeutralPlace, Memory]:
        """Return a place with its range: a turn if all comes round with one, else where it went from its start on.

        Where nothing follows it that is the start alone, and the memory is that with the place there.
        All else moves `along` with it.
        """
        first, now = (held_in(memory, entry, self.rings) for memory in (self.begun, self.memory))
        here = self.mapped(self.memory)
        if self.turns(entry, here):
            return NeutralPlace(entry, now, -0.5, 0.5, turns=True), self.memory
        step = first - now or _TRIED * max(abs(now), 1.0)
        there, size = self.mapped(self._along(along, step)), np.abs(self.numbers(self.memory))
        if (np.abs(there - here) @ size <= _ALIKE * np.abs(here) @ size).all():
            return NeutralPlace(entry, first, first, first, alone=True), self._along(along, first - now)
        return NeutralPlace(entry, now, min(first, now), max(first, now)), self.memory

    def _along(self, along: Mapping[Entry, float], step: float) -> Memory:
        return moved(self.memory, {one: step * by for one, by in along.items()}, self.rings)


class Image(NamedTuple):
    """Outcome of a period for some numbers."""

    after: list[Any]
    outputs: list[Any]
    passed: list[Any]  # by each place


def put_back(image: Image, along: Sequence[Sequence[Any]]) -> list[Any]:
    """Return what comes of some numbers, moved back along curves to where places were."""
    after = image.after
    for number, passed in enumerate(image.passed):
        by = [row[number] for row in along]
        after = [x - passed * own if is_there(own) else x for x, own in zip(after, by, strict=True)]
    return after


def is_there(number: Any) -> bool:
    """Return whether a number is more than an exact zero."""
    return not isinstance(number, float) or number != 0.0


def entries_of(model: TaylorModel) -> list[list[Any]]:
    """Return the entries of a matrix as numbers."""
    rows, columns = model.radius.shape
    return [[PolynomialBall(_entry(model, i, j)) for j in range(columns)] for i in range(rows)]


def _entry(model: TaylorModel, i: int, j: int) -> TaylorModel:
    return TaylorModel(model.of, model.coefficients[:, i, j], model.radius[i, j]).pruned


def neutral(a: Array, chosen: Sequence[int] | None = None) -> tuple[Sequence[int], Array]:
    """Return places among the states of a map, and how the other states move with them where all stays as it is."""
    n = len(a)
    if not n:
        return [], np.zeros((0, 0))
    if not np.isfinite(a).all():
        raise UndecidedError(_UNKNOWN)
    apart = np.sort(np.abs(np.linalg.eigvals(a) - 1.0))
    within = _NEUTRAL if chosen is None else 0.5 * float(apart[len(chosen) - 1] + apart[len(chosen)])
    schur: Any = scipy.linalg.schur
    _, vectors, count = schur(a, sort=lambda re, im=0.0: abs(re + 1j * im - 1.0) < within)
    if chosen is not None and count != len(chosen):
        raise UndecidedError(_UNKNOWN)
    basis = vectors[:, :count]
    if chosen is None:
        qr: Any = scipy.linalg.qr
        weighted = basis * np.abs(np.diag(a))[:, None]
        order = qr(weighted.T, pivoting=True, mode="r")[1] if count else []
        chosen = sorted(int(i) for i in order[:count])
    try:
        along = basis @ np.linalg.inv(basis[chosen])
    except np.linalg.LinAlgError:
        raise UndecidedError(_UNKNOWN) from None
    return chosen, along[[i for i in range(n) if i not in chosen]]


def along_curves(slopes: TaylorModel, begin: Sequence[Sequence[Any]], left: Array) -> TaylorModel:
    """Return about how all that moves moves with its places, by the slopes of all: polynomials."""
    along, inverse = model_of(begin).middles, TaylorModel.constant(left)
    of_x, of_p, p_of_x, p_of_p = quarters(slopes, len(left))
    for _ in range(_STEPS):
        along = (along + inverse @ (of_x @ along + of_p - along @ (p_of_x @ along + p_of_p))).middles
    return along


def returned(rows: list[list[Any]], order: int, along: Sequence[Sequence[Any]]) -> list[list[Any]]:
    """Return the map of a period, after which all is moved back along curves to where its places were.

    The last of the `order` states are the places.
    """
    first = len(along)
    passed = [row[:first] + row[order:] for row in rows[first:order]]
    moved = [
        [
            x - sum((t * by[j] for t, by in zip(own, passed, strict=True)), 0.0)
            for j, x in enumerate(row[:first] + row[order:])
        ]
        for row, own in zip(rows, along, strict=False)
    ]
    return moved + [row[:first] + row[order:] for row in rows[order:]]


def check_unseen(rows: list[list[Any]], order: int, moving: Sequence[int], along: Sequence[Sequence[Any]]) -> None:
    """Raise `UndecidedError` where a loop, which is opened at a wire, sees the places of its last states.

    It does if their poles, which are one, move with a factor at the wire: by how the place moves the
    wire, times how the wire moves the place in the long run. States that are not `moving` are no part
    of it.
    """
    middles = np.array([[float(arb_of(value).mid()) for value in row] for row in rows])
    a, b, c, d = quarters(middles, order)
    a, b, c, first = a[np.ix_(moving, moving)], b[moving], c[:, moving], len(moving) - order + len(along)
    own = [*along, *np.eye(order - len(along)).tolist()]
    seen = (model_of([row[:order] for row in rows[order:]]) @ model_of(own)).whole
    try:
        closed = np.linalg.inv(np.eye(len(d)) - d)
        values, vectors = np.linalg.eig((a + b @ closed @ c).T)
        left = vectors[:, np.argsort(np.abs(values - 1.0))[: order - len(along)]].T
        into = np.linalg.solve(left[:, first:], left @ b @ closed)
    except np.linalg.LinAlgError:
        raise UndecidedError(_UNKNOWN) from None
    if not (np.abs(into) @ (np.abs(closed) @ seen) <= _SLOW).all():
        raise UndecidedError("the loop sees the place of what comes to no rest")


def tangents(slopes: TaylorModel, begin: Sequence[Sequence[Any]], left: Array) -> list[list[Any]]:
    """Return how all that moves moves with its places, enclosed: T within E; raises `UndecidedError`."""
    along = along_curves(slopes, begin, left)
    inverse, (n, m) = TaylorModel.constant(left), along.radius.shape
    of_x, of_p, p_of_x, p_of_p = quarters(slopes, n)
    passed = p_of_x @ along + p_of_p
    step = (inverse @ (of_x @ along + of_p - along @ passed)).whole
    inner = (inverse @ (of_x - along @ p_of_x) - inverse).moved(np.eye(n)).whole
    across, beyond, onward = np.abs(left), passed.moved(-np.eye(m)).whole, p_of_x.whole
    reach = step
    for _ in range(_WIDENED):
        needed = step + inner @ reach + across @ (reach @ beyond + reach @ (onward @ reach))
        if (needed * _UP + _LEAST <= reach).all():
            if not (beyond + onward @ reach <= _SLOW).all():
                raise UndecidedError("a pole of a place is not one")
            return entries_of(along.within(reach))
        reach = np.maximum(reach, _ROOM * (needed * _UP + _LEAST))
    raise UndecidedError(_UNKNOWN)
