"""Taylor models: numbers and matrices that follow a few coordinates closely, in doubles.

    x(d) is within r of the sum over k of c_k d^k for all d, each |d_i| <= 1

The radius r holds what a product has beyond the order that is kept, and the rounding of all
coefficients (Makino and Berz, Int. J. Pure and Applied Mathematics 4, 2003, 379). A sum of m
products is off by at most (m + 1) u of the sum of their sizes, u = 2^-53, in any order (Higham,
Accuracy and Stability of Numerical Algorithms, section 3.5).
"""

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, reduce
from typing import Any, NamedTuple

import numpy as np

from proofmass.runner.derivatives.ball import LEAST, UNIT, UP
from proofmass.runner.host.arrays import AnyArray, Array, Integers, Truths

_HIGHEST, _MOST = 6, 12_500  # order of the terms that are kept, and pairs of terms of a product
_TABLES = 1024  # of products that are kept


@lru_cache
def order_kept(coordinates: int) -> int:
    """Return the order up to which a product keeps its terms."""
    orders = range(_HIGHEST, 1, -1)
    return next((order for order in orders if math.comb(2 * coordinates + order, order) <= _MOST), 1)


@dataclass(frozen=True, eq=False)
class Monomials:
    """Products d^k of coordinates, by order: the first is one.

    Equal ones are the same object, while they are remembered.
    """

    exponents: Integers  # (products, coordinates)

    @cached_property
    def orders(self) -> Integers:
        """The order of each product."""
        return np.asarray(self.exponents.sum(axis=1))

    @cached_property
    def firsts(self) -> Integers:
        """Places at which the orders that there are begin."""
        return np.flatnonzero(np.diff(self.orders, prepend=-1))

    @property
    def width(self) -> int:
        """The number of coordinates."""
        return int(self.exponents.shape[1])

    @cached_property
    def last(self) -> int:
        """The highest order."""
        return int(self.orders[-1])

    @cached_property
    def even(self) -> AnyArray:
        """Products that are never negative, without one."""
        even: AnyArray = (self.exponents % 2 == 0).all(axis=1)
        even[0] = False
        return even


@lru_cache(_TABLES)
def _interned(data: bytes, shape: tuple[int, int]) -> Monomials:
    return Monomials(np.frombuffer(data, dtype=np.int64).reshape(shape))


def monomials(exponents: Any) -> Monomials:
    """Return products of coordinates by their exponents, which are in ascending order."""
    rows = np.ascontiguousarray(exponents, dtype=np.int64)
    return _interned(rows.tobytes(), rows.shape)


ONE = monomials(np.zeros((1, 0)))


def _widened(of: Monomials, width: int) -> Integers:
    return np.pad(of.exponents, ((0, 0), (0, width - of.width)))


class _Table(NamedTuple):
    """Pairs of terms of a product of two polynomials, and where those of each of its own terms begin."""

    left: Integers
    right: Integers
    starts: Integers
    of: Monomials
    most: int  # terms that come together
    order: int


def _alike(rows: Integers) -> tuple[Integers, Integers, Monomials]:
    """Return an order of rows of exponents in which those alike lie together, and where each begins."""
    by_order = np.column_stack([rows.sum(axis=1), rows])
    order = np.lexsort(by_order.T[::-1])
    sorted_rows = rows[order]
    new = np.ones(len(rows), dtype=bool)
    new[1:] = (sorted_rows[1:] != sorted_rows[:-1]).any(axis=1)
    return order, np.flatnonzero(new), monomials(sorted_rows[new])


@lru_cache(_TABLES)
def _products(left: Monomials, right: Monomials) -> _Table:
    width = max(left.width, right.width)
    order = order_kept(width)
    i, j = np.nonzero(left.orders[:, None] + right.orders <= order)
    sort, starts, of = _alike(_widened(left, width)[i] + _widened(right, width)[j])
    most = int(np.diff(starts, append=len(sort)).max())
    return _Table(i[sort], j[sort], starts, of, most, order)


@lru_cache(_TABLES)
def _union(left: Monomials, right: Monomials) -> tuple[Monomials, Integers, Integers]:
    """Return all products of two, and where theirs are among them."""
    width = max(left.width, right.width)
    sort, starts, of = _alike(np.concatenate([_widened(left, width), _widened(right, width)]))
    places = np.empty(len(sort), dtype=np.int64)
    places[sort] = np.repeat(np.arange(len(starts)), np.diff(starts, append=len(sort)))
    return of, places[: len(left.orders)], places[len(left.orders) :]


@dataclass(frozen=True, eq=False)
class TaylorModel:
    """A number or a matrix that is a polynomial of coordinates, within a radius."""

    of: Monomials
    coefficients: Array  # one for each product: numbers or matrices
    radius: Any  # of a number, or of each entry

    @classmethod
    def constant(cls, middle: Any, radius: Any = 0.0) -> "TaylorModel":
        """Return a number or a matrix that does not follow the coordinates."""
        middle = np.asarray(middle, dtype=np.float64)
        return cls(ONE, middle[None], np.broadcast_to(radius, middle.shape))

    @cached_property
    def sizes(self) -> Array:
        """Sums of the sizes of terms of the same order."""
        return np.asarray(np.add.reduceat(np.abs(self.coefficients), self.of.firsts, axis=0) * UP)

    @cached_property
    def size(self) -> Any:
        """The sum of the sizes of all terms, without the radius."""
        return self.sizes.sum(axis=0) * UP

    @property
    def whole(self) -> Any:
        """Bounds of all that it may be."""
        return (self.size + self.radius) * UP

    @property
    def name(self) -> object:
        """A name that those have in common that are the same."""
        return self.of, self.coefficients.tobytes(), self.radius.tobytes()

    @property
    def present(self) -> bool:
        """False if it is zero everywhere."""
        return bool(self.coefficients.any() or np.any(self.radius))

    @property
    def middles(self) -> "TaylorModel":
        """The polynomial alone."""
        return TaylorModel(self.of, self.coefficients, 0.0 * self.radius)

    @property
    def pruned(self) -> "TaylorModel":
        """A polynomial without its terms that are zero, but for the constant."""
        there: Truths = np.any(self.coefficients.reshape(len(self.coefficients), -1), axis=1)
        there[0] = True
        if there.all():
            return self
        return TaylorModel(monomials(self.of.exponents[there]), self.coefficients[there], self.radius)

    def ends(self) -> tuple[Any, Any]:
        """Return the middle of all that it may be, and at least the distance to each end."""
        half = self.coefficients[self.of.even].sum(axis=0) * 0.5
        middle = self.coefficients[0] + half
        apart = self.size - np.abs(self.coefficients[0]) - np.abs(self.coefficients[self.of.even]).sum(axis=0) * 0.5
        rounding = 2 * (len(self.coefficients) + 4) * UNIT * self.size
        return middle, (np.maximum(apart, 0.0) + rounding + self.radius) * UP

    def __add__(self, other: "TaylorModel") -> "TaylorModel":
        if self.of is other.of:
            of, total = self.of, self.coefficients + other.coefficients
        else:
            of, left, right = _union(self.of, other.of)
            shape = np.broadcast_shapes(self.coefficients.shape[1:], other.coefficients.shape[1:])
            total = np.zeros((len(of.orders), *shape))
            total[left] = self.coefficients
            total[right] += other.coefficients
        found = TaylorModel(of, total, 0.0)
        return found.within(self.radius + other.radius + UNIT * found.size)

    def __neg__(self) -> "TaylorModel":
        return TaylorModel(self.of, -self.coefficients, self.radius)

    def __sub__(self, other: "TaylorModel") -> "TaylorModel":
        return self + -other

    def within(self, radius: Any) -> "TaylorModel":
        """Return the polynomial within another radius, rounded up."""
        return TaylorModel(self.of, self.coefficients, radius * UP)

    def moved(self, middle: Any, radius: Any = 0.0) -> "TaylorModel":
        """Return it with a number, known within a radius, added to each entry."""
        total = self.coefficients.copy()
        total[0] += middle
        return TaylorModel(self.of, total, (self.radius + radius + UNIT * np.abs(total[0])) * UP)

    def scaled(self, middle: float, radius: float = 0.0) -> "TaylorModel":
        """Return it times a number that is known within a radius."""
        apart = self.radius * abs(middle) + self.whole * radius + UNIT * abs(middle) * self.size + LEAST
        return TaylorModel(self.of, self.coefficients * middle, apart * UP)

    def __mul__(self, other: "TaylorModel") -> "TaylorModel":
        return _product(self, other, np.multiply, 1)

    def __matmul__(self, other: "TaylorModel") -> "TaylorModel":
        return _product(self, other, np.matmul, other.coefficients.shape[1])

    def placed(self, places: Callable[[Array], Any]) -> "TaylorModel":
        """Return its entries placed anew."""
        return TaylorModel(self.of, places(self.coefficients), places(self.radius))

    def __getitem__(self, place: Any) -> "TaylorModel":
        return TaylorModel(self.of, self.coefficients[(slice(None), *place)], self.radius[place]).pruned

    def at_corners(self, places: Sequence[int]) -> tuple[Array, Array]:
        """Return the polynomial with some coordinates at their ends and the others in the middle, and
        bounds of its rounding.

        The last of these coordinates is the fastest; the radius is left out.
        """
        known = [place for place in places if place < self.of.width]
        powers = self.of.exponents[:, known]
        moving = np.flatnonzero(powers.sum(axis=1) == self.of.orders)
        odd = np.zeros((len(moving), len(places)), dtype=np.int64)
        odd[:, [places.index(place) for place in known]] = powers[moving] % 2
        signs = np.array([*itertools.product((-1.0, 1.0), repeat=len(places))]).reshape(1 << len(places), len(places))
        weights = np.where(odd == 1, signs[:, None], 1.0).prod(axis=2)
        middle = np.tensordot(weights, self.coefficients[moving], 1)
        return middle, np.broadcast_to((len(moving) + 2) * UNIT * UP * self.size, middle.shape)


def _product(left: TaylorModel, right: TaylorModel, of_two: Callable[..., Any], inner: int) -> TaylorModel:
    table = _products(left.of, right.of)
    terms = of_two(left.coefficients[table.left], right.coefficients[table.right])
    total = np.add.reduceat(terms, table.starts, axis=0) if len(terms) > len(table.starts) else terms
    rounding = (inner + table.most + 2) * UNIT
    radius = of_two(left.size, right.size * rounding + right.radius) + of_two(left.radius, right.whole) + LEAST
    if left.of.last + right.of.last > table.order:
        orders = right.of.orders[right.of.firsts]
        for size, own in zip(left.sizes, left.of.orders[left.of.firsts], strict=True):
            beyond = right.sizes[orders > table.order - own]
            if len(beyond):
                radius = radius + of_two(size, beyond.sum(axis=0) * UP)
    return TaylorModel(table.of, total, radius * UP)


def stacked(numbers: Sequence[TaylorModel], shape: tuple[int, int]) -> TaylorModel:
    """Return numbers as a matrix of some shape, by rows."""
    of = _of_all(numbers)
    coefficients = np.zeros((len(of.orders), len(numbers)))
    for i, number in enumerate(numbers):
        coefficients[_union(of, number.of)[2], i] = number.coefficients
    radius = np.array([float(number.radius) for number in numbers])
    return TaylorModel(of, coefficients.reshape(len(coefficients), *shape), radius.reshape(shape)).pruned


def joined(parts: Sequence[Sequence[TaylorModel]]) -> TaylorModel:
    """Return blocks of matrices as one."""
    of = _of_all([part for row in parts for part in row])
    coefficients, radius = (
        np.concatenate([np.concatenate([array(part) for part in row], axis=-1) for row in parts], axis=-2)
        for array in (lambda part: _spread(part, of), lambda part: part.radius)
    )
    return TaylorModel(of, coefficients, radius)


def _of_all(models: Sequence[TaylorModel]) -> Monomials:
    """Return all products of coordinates that some models have."""
    return reduce(lambda of, other: _union(of, other)[0], dict.fromkeys(model.of for model in models), ONE)


def _spread(model: TaylorModel, of: Monomials) -> Array:
    whole = np.zeros((len(of.orders), *model.coefficients.shape[1:]))
    whole[_union(of, model.of)[2]] = model.coefficients
    return whole
