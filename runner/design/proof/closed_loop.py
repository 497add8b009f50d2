"""A loop closed with a factor at its wire, over a box of coordinates q = m + d, |d_i| <= h_i.

    x[n+1] = (A + B F (I - D F)^-1 C) x[n]

F is the factor g of a gain, or [[cos p, -sin p], [sin p, cos p]] of a phase p, whose matrices act
on real and imaginary part: the loop then has twice as many states. D joins a value of the wire with
later ones, so that the inverse is a sum of as many powers as a period has values.

The matrix is a polynomial of d_i / h_i, and lies between those at the corners of the box: each term
c d^k with a power of two or more adds |c|, since even powers are 1 at all corners, and of d^k -
d^(k mod 2) no more than 1 is left. An amplifier's gain has no such term: all of its tolerance is
exact. Coordinates beyond the first few stay in the middle, and their terms add |c| too. Of sampled
loops each such term adds its spectral norm instead, in the coordinates of the norm: corners are
moved by half of c where d^k is never negative, so that half of it is left. Their states are turned
into coordinates S, in which what is unknown is narrow: S^-1 A S has the poles of A.

All complex factors (2 + a d) / (2 - a d) with |d| <= 1 are one matrix. With E = (I - D)^-1 it is

    [ A + B E C     B E           ]
    [ a E C         a (E - I / 2) ]

from x and w to x[n+1] and z, where w = d z. If it shortens every vector, in coordinates that leave
w and z as they are, then x[n+1] is shorter than x for each d (the bounded real lemma; Zhou, Doyle
and Glover, Robust and Optimal Control, chapter 21). A response is at most x at all frequencies, |C
(z - A)^-1 B + D| <= x, if [A, B; C / x, D / x] does so.
"""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import flint
import numpy as np

from proofmass.runner.derivatives.ball import UNIT, UP, UndecidedError
from proofmass.runner.derivatives.polynomial import model_of
from proofmass.runner.derivatives.taylor_model import TaylorModel, joined
from proofmass.runner.design.proof.ball_map import BallMap
from proofmass.runner.design.proof.enclosed import Enclosed, RestPoint, quarters
from proofmass.runner.design.proof.tick_products import TickProducts
from proofmass.runner.design.proof.wire_factors import Factor
from proofmass.runner.host.arrays import Array, Integers, Truths

MapParts = tuple[TaylorModel, TaylorModel, TaylorModel, TaylorModel]  # A, B, C and D, as polynomials of d_i / h_i


@dataclass(frozen=True)
class Disc:
    """A disc in the plane of poles."""

    real: float  # of the centre
    imaginary: float
    radius: float

    @property
    def empty(self) -> bool:
        """True if no pole lies in it."""
        return not self.radius > 0.0

    def moved(self, family: "Family", parts: int) -> "Family":
        """Return the matrices (M - centre) / radius: their poles lie in the disc of radius 1 if M's lie in this."""
        if (self.real, self.imaginary, self.radius) == (0.0, 0.0, 1.0):
            return family
        turned = [[self.real, -self.imaginary], [self.imaginary, self.real]] if parts == 2 else [[self.real]]
        centre = np.asarray(np.kron(turned, np.eye(family.corners.middle.shape[-1] // parts)), dtype=np.float64)
        moved = family.corners.moved(-centre).scaled(1.0 / self.radius)
        scale = UP / self.radius
        shares, bends = ({i: of * scale for i, of in part.items()} for part in (family.shares, family.bends))
        sensors = None if family.sensors is None else (family.sensors - centre) / self.radius
        return replace(family, corners=moved, shares=shares, bends=bends, sensors=sensors)

    def beyond(self, family: "Family") -> Array:
        """Return how far matrices may lie beyond the corners of a certificate, of the family that was moved."""
        return np.asarray(sum(family.shares.values(), 0.0 * family.centre) * (self.radius * (1.0 + 2.0**-39)))

    def as_data(self) -> dict[str, list[float]]:
        """Return it as plain data, for certificates."""
        return {"disc": [self.real, self.imaginary, self.radius]}


@dataclass(frozen=True)
class OpenCorners:
    """An open loop over a box: [A B; C D] at its corners, and its parts as polynomials."""

    order: int
    values: int  # of the wire in a period
    corners: Enclosed  # a matrix for each corner
    around: Callable[[], MapParts] | None  # in all of the box
    rest: RestPoint | None  # where the sensors of the box rest, None at the start of a run
    interpolated: tuple[int, ...]  # coordinates that are at both ends among the corners; the others are in the middle
    sides: int  # coordinates of the box, without the factor's
    ticks: "ClosedTicks | None" = None  # the ticks of a loop, where they are known one by one
    frame: Array | None = None  # S: the states are S times these
    continuous: bool = False  # A has rates

    @cached_property
    def terms(self) -> MapParts:
        """A, B, C and D in all of the box."""
        if self.around:
            return self.around()
        a, b, c, d = map(TaylorModel.constant, quarters(0.0 * self.corners.middle[0], self.order))
        return a, b, c, d

    def shares(self, terms: TaylorModel) -> dict[int, Array]:
        """Return what each coordinate adds beyond the corners, of a matrix of the box."""
        return shares_of(terms, {*self.interpolated}, self.sides)

    def framed(self, frame: Array) -> "OpenCorners":
        """Return the loop with its states in coordinates S of their own."""
        n = self.order
        back = _inverse(frame)
        a, b, c, d = quarters(self.corners, n)
        turned = Enclosed.exact(frame)
        return replace(self, corners=Enclosed.joined([[back @ a @ turned, back @ b], [c @ turned, d]]), frame=frame)

    @property
    def proving(self) -> "OpenCorners":
        """The loop with what proves alone: no more has to travel and to be kept."""
        there = self.rest
        rest = None if there is None else replace(there, curve=there.centre.tolist(), places=(), along=())
        return replace(self, around=None, ticks=None, rest=rest)


@dataclass(frozen=True)
class ClosedTicks:
    """The ticks of a loop, and its products that were asked for."""

    of: TickProducts
    known: dict[Any, TaylorModel] = field(default_factory=dict)

    def terms(self, factor: Factor, ends: tuple[float, float], chord: bool, last: int) -> TaylorModel:
        """Return the closed loop over a period as a polynomial."""
        key = factor.name, ends
        if key not in self.known:
            self.known[key] = self.of.closed(factor.model(*ends, chord, last), factor.parts)
        return self.known[key]


def _inverse(matrix: Array) -> Enclosed:
    try:
        inverse: Any = flint.arb_mat(matrix.tolist()).inv()
    except ZeroDivisionError:
        raise UndecidedError("coordinates that are not independent") from None
    return Enclosed.of_balls([inverse.tolist()])


def _constant(matrix: Enclosed) -> TaylorModel:
    return TaylorModel.constant(matrix.middle[0], matrix.radius[0])


@dataclass(frozen=True)
class Family:
    """The matrices of a closed loop over a box: those at the corners, and how far the others may lie beyond them."""

    corners: Enclosed  # the corners of all coordinates, the factor's the fastest
    factors: int  # at each corner of the others
    shares: Mapping[int, Array]  # what each coordinate adds, entry by entry
    bends: Mapping[int, Array] = field(default_factory=dict)  # and up to once each of these matrices, to both sides
    shift: Array | None = None  # by which the corners were moved, into the middle between these sides
    sensors: Array | None = None  # then those that were not moved, and last the sensor in the middle
    still: int = 0  # last coordinates that a norm leaves as they are
    blocks: tuple[int, ...] = ()  # sizes of matrices that lie side by side, if there are several
    left: Array | None = None  # what a matrix at rest was multiplied by (`at_rest`)
    noise: Enclosed | None = None  # [B; D] of sources at the corners (`noise_norm`)
    beyond_noise: Array | None = None  # how far others may lie beyond those
    limit: float = math.inf  # of what it adds
    opened: OpenCorners | None = None  # the loop that is closed, in its coordinates
    rates: "Family | None" = None  # of a continuous loop, for whose norms this one stands

    def parts(self) -> "list[Family]":
        """Return the families of the matrices that lie side by side."""
        ends = list(itertools.accumulate(self.blocks))
        places = [slice(end - size, end) for end, size in zip(ends, self.blocks, strict=True)]
        return [
            replace(self, corners=self.corners[i, i], shares={k: s[i, i] for k, s in self.shares.items()}, blocks=())
            for i in places
        ]

    @property
    def centre(self) -> Array:
        """The sensor in the middle; where it is not known the mean of the corners."""
        return np.asarray(self.corners.middle.mean(axis=0) if self.sensors is None else self.sensors[-1])

    def moves(self) -> Array:
        """Return by how much the matrix moves with each coordinate that is at both ends among the corners."""
        corners = self.corners.middle.reshape(-1, self.factors, *self.corners.middle.shape[1:])
        number = len(corners)
        count = number.bit_length() - 1
        signs = np.array(list(itertools.product((-1.0, 1.0), repeat=count))).reshape(number, count)
        moves = list(np.tensordot(signs.T, corners.mean(axis=1), 1) / number)
        if self.factors > 1:
            moves.append(0.5 * (corners[:, 1] - corners[:, 0]).mean(axis=0))
        return np.array(moves).reshape(-1, *self.corners.middle.shape[1:])


def parts_of(of: BallMap) -> MapParts:
    """Return A, B, C and D of a map."""
    a, b, c, d = quarters(model_of(of.rows), of.order)
    return a, b, c, d


def bend(of: BallMap, place: int) -> float:
    """Return how far an open loop bends along a coordinate of a box."""
    model = model_of(of.rows)
    twice = np.flatnonzero((model.of.orders == 2) & (model.of.exponents[:, place : place + 1] == 2).any(axis=1))
    return float(np.abs(model.coefficients[twice]).sum())


def closed_loops(factor: Factor, of: OpenCorners, ends: tuple[float, float]) -> Family:
    """Return the loop closed with all factors between two `ends`, over a box."""
    last = of.sides
    chord = of.values == 1  # the loop is linear in the factor
    factors = factor.corners(*ends, chord)
    stacked = Enclosed.interleaved([_closed_at(of, f) for f in factors])
    if of.ticks is None:
        terms = closed_terms(of.terms, of.values, factor.model(*ends, chord, last), factor.parts)
    else:
        terms = of.ticks.terms(factor, ends, chord, last)
    if of.frame is not None:
        back, unit = _inverse(of.frame), np.eye(factor.parts)
        to = np.kron(unit, of.frame)
        terms = _constant(back.repeated(factor.parts)) @ terms @ TaylorModel.constant(to)
    exact = {*of.interpolated, last, last + chord}
    if of.continuous:
        return Family(stacked, len(factors), shares_of(terms, exact, last))
    shift, bends = bends_of(terms, exact, last)
    most = max(bends, key=lambda i: float(np.linalg.norm(bends[i], axis=(1, 2)).sum()), default=last)
    rounding = len(terms.coefficients) * UNIT * terms.size  # of the shift
    unknown = {most: (2.0 * terms.radius + rounding) * UP}
    sensors = np.concatenate([stacked.middle, terms.coefficients[:1]])
    return Family(stacked.moved(shift), len(factors), unknown, bends, shift, sensors, opened=of)


def shares_of(model: TaylorModel, exact: set[int], last: int) -> dict[int, Array]:
    """Return what each coordinate adds beyond the corners, of which `last` is the factor's.

    What is not known of any term may differ between corners and what lies among them.
    """
    beyond, owners, _ = _beyond(model, exact, last)
    sizes = np.abs(model.coefficients[beyond]) * UP
    shares = {int(i): sizes[owners == i].sum(axis=0) * UP for i in np.unique(owners)}
    if np.any(model.radius):
        most = max(shares, key=lambda i: float(shares[i].sum()), default=last)
        shares[most] = (shares.get(most, 0.0) + 2.0 * model.radius) * UP
    return shares


def bends_of(model: TaylorModel, exact: set[int], last: int) -> tuple[Array, dict[int, Array]]:
    """Return by what corners are to be moved, and the matrices beyond them, to both sides, by the
    coordinate that owns them.

    A square c d^2 lies between 0 and c. The corners have c, or none of a coordinate in the middle:
    moved by half of it, they are off by half of it.
    """
    beyond, owners, inexact = _beyond(model, exact, last)
    terms, even = model.coefficients[beyond].copy(), model.of.even[beyond]
    terms[even] *= 0.5
    shift = terms[even & inexact].sum(axis=0) - terms[even & ~inexact].sum(axis=0)
    return shift, {int(i): terms[owners == i] for i in np.unique(owners)}


def _beyond(model: TaylorModel, exact: set[int], last: int) -> tuple[Integers, Integers, Truths]:
    """Return which terms corners do not have, the coordinate that moves each most, and whether one of
    its coordinates is at no end.
    """
    powers = model.of.exponents
    middle: Truths = np.any(powers[:, [i for i in range(model.of.width) if i not in exact]], axis=1)
    beyond = np.flatnonzero(np.any(powers > 1, axis=1) | middle)
    owners = np.minimum(powers[beyond].argmax(axis=1), last) if len(beyond) else beyond
    return beyond, owners, middle[beyond]


def with_disk(of: OpenCorners, ends: tuple[float, float]) -> Family:
    """Return the matrix of all factors of a disk, of size `ends`, which are equal, over a box."""
    size, n, k = ends[0], of.order, of.values
    a, b, c, d = quarters(of.corners, n)
    e = power = Enclosed.exact(np.zeros_like(d.middle)).moved(np.eye(k))
    for _ in range(k - 1):
        power = d @ power
        e = e + power
    b = b @ e
    below = (e @ c).scaled(size), e.moved(-0.5 * np.eye(k)).scaled(size)
    corners = Enclosed.joined([[a + b @ c, b], list(below)])
    return Family(corners, 1, of.shares(disk_terms(of.terms, size)), still=k)


def through(of: OpenCorners, ends: tuple[float, float]) -> Family:
    """Return the matrix of a response with its output over a limit, both `ends`, over a box."""
    limit, n, k = ends[0], of.order, of.values
    a, b, c, d = of.terms
    below = [part.scaled(1.0 / limit, UNIT / limit) for part in (c, d)]
    shares = of.shares(joined([[a, b], below]))
    above, under = (of.corners[rows, slice(None)] for rows in (slice(None, n), slice(n, None)))
    corners = Enclosed.joined([[above], [under.scaled(1.0 / limit)]])
    return Family(corners, 1, shares, still=k)


def disk_terms(parts: MapParts, size: float) -> TaylorModel:
    """Return the matrix of all factors of a disk as a polynomial."""
    a, b, c, d = parts
    values = np.eye(d.coefficients.shape[1])
    e = power = TaylorModel.constant(values)
    for _ in range(len(values) - 1 if d.present else 0):
        power = d @ power
        e = e + power
    b = b @ e
    return joined([[a + b @ c, b], [(e @ c).scaled(size), e.moved(-0.5 * values).scaled(size)]])


def _closed_at(of: OpenCorners, factor: Sequence[Sequence[Any]]) -> Enclosed:
    """Return the loops at the corners closed with one factor."""
    n, parts = of.order, len(factor)
    f = Enclosed.of_balls([factor]).spread(of.values)
    a, b, c, d = (part.repeated(parts) for part in quarters(of.corners, n))
    power = back = f @ c
    for _ in range(of.values - 1):
        power = f @ (d @ power)
        back = back + power
    return a + b @ back


def closed_terms(of: MapParts, values: int, wire: TaylorModel, parts: int) -> TaylorModel:
    """Return the loop closed with factors of so many parts at its wire, as a polynomial."""
    a, b, c, d = (part.placed(lambda matrix: np.kron(np.eye(parts), matrix)) for part in of)
    f = wire.placed(lambda factor: np.kron(factor, np.eye(values)))  # for each value of the wire
    power = back = f @ c
    for _ in range(values - 1 if d.present else 0):
        power = f @ (d @ power)
        back = back + power
    return a + b @ back
