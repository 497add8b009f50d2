"""Polynomials of a few coordinates in balls: numbers and matrices that follow parameters closely (Taylor models).

    x(d) is in the sum over k of c_k d^k for all d, each |d_i| <= 1

The c_k are balls; what a product has beyond the order that is kept is within the radius of c_0
(Makino and Berz, Int. J. Pure and Applied Mathematics 4, 2003, 379). A ball alone forgets which
parameters it came from, so that products of many of them grow wide; a polynomial is off by the
terms that are left out.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from typing import Any

import flint

from proofmass.runner.continuous.exact_hold import balance
from proofmass.runner.derivatives.ball import LAST_PLACES, Ball, UndecidedError, arb_of

ORDER = 4  # of the terms that are kept
Key = tuple[int, ...]  # numbers of the coordinates in a product, in ascending order
Terms = Mapping[Key, Any]  # Arb's numbers or matrices
_SERIES, _SMALL = 24, 0.5  # terms of an exponential, and the norm up to which these leave less than the last places
_LARGE = 2.0**20  # norm of what is no exponential of a tick


def product(left: Terms, right: Terms) -> Terms:
    """Return the product of two polynomials of numbers or matrices, up to `ORDER`."""
    total: dict[Key, Any] = {}
    for one, u in left.items():
        for other, v in right.items():
            if len(one) + len(other) <= ORDER:
                key, term = _times(one, other), u * v
                total[key] = total[key] + term if key in total else term
    if max(map(len, left), default=0) + max(map(len, right), default=0) <= ORDER:
        return total
    sizes, others = _sizes_by_order(left), _sizes_by_order(right)
    beyond = [sizes[i] * others[j] for i in sizes for j in others if i + j > ORDER]
    for size in beyond:
        apart = size * flint.arb(0, 1)
        total[()] = total[()] + apart if () in total else apart
    return total


def added(left: Terms, right: Terms) -> Terms:
    """Return the sum of two polynomials."""
    both = dict(left)
    for key, term in right.items():
        both[key] = both[key] + term if key in both else term
    return both


def _sizes_by_order(of: Terms) -> Mapping[int, Any]:
    sizes: dict[int, Any] = {}
    for key, term in of.items():
        size, order = size_of(term), len(key)
        sizes[order] = sizes[order] + size if order in sizes else size
    return sizes


def size_of(term: Any) -> Any:
    """Return bounds of the sizes of a number or of the entries of a matrix."""
    if isinstance(term, flint.arb):
        return term.abs_upper()
    return flint.arb_mat([[value.abs_upper() for value in row] for row in term.tolist()])


@cache
def _range_of(key: Key) -> Any:
    """Return all that a product of coordinates may be."""
    even = all(key.count(i) % 2 == 0 for i in key)
    return flint.arb(1) if not key else flint.arb(0.5, 0.5) if even else flint.arb(0, 1)


@cache
def _times(one: Key, other: Key) -> Key:
    return tuple(sorted(one + other))


class PolynomialBall(Ball):
    """A number that follows coordinates.

    >>> x = PolynomialBall.coordinate(1.0, 2.0, 0)
    >>> (x * x - x * x).ends()[1] < 1e-25
    True
    """

    __slots__ = ("functions", "terms")

    def __init__(self, terms: Terms) -> None:
        self.terms = terms
        self.functions: dict[Any, Any] = {}  # asked for: a slope asks for the value again

    @classmethod
    def coordinate(cls, low: float, high: float, number: int) -> Any:
        """Return the coordinate of a number, between two ends."""
        middle, half = (flint.arb(low) + high) / 2, (flint.arb(high) - low) / 2
        return cls({(): middle, (number,): half}) if low < high else Ball(middle)

    @property
    def arb(self) -> Any:
        """All that it may be, as one of Arb's."""
        total = flint.arb(0)
        for key, term in self.terms.items():
            total += term * _range_of(key)
        if not total.is_finite():
            raise UndecidedError("a number without bounds")
        return total

    @property
    def middles(self) -> "PolynomialBall":
        """The polynomial whose coefficients are the middles of these."""
        return PolynomialBall({key: term.mid() for key, term in self.terms.items()})

    def __repr__(self) -> str:
        return f"PolynomialBall({ {key: Ball(term) for key, term in self.terms.items()} })"

    def widened(self) -> "PolynomialBall":
        """Return the number with the last places of each value as a further radius."""
        return PolynomialBall({key: term * flint.arb(1, LAST_PLACES) for key, term in self.terms.items()})

    def __add__(self, other: Any) -> Any:
        terms = _terms_of(other)
        return NotImplemented if terms is None else PolynomialBall(added(self.terms, terms))

    __radd__ = __add__

    def __neg__(self) -> "PolynomialBall":
        return PolynomialBall({key: -term for key, term in self.terms.items()})

    def __sub__(self, other: Any) -> Any:
        return self + -other

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __mul__(self, other: Any) -> Any:
        terms = _terms_of(other)
        if isinstance(other, int | float) and other == 0.0:
            return 0.0
        return NotImplemented if terms is None else PolynomialBall(product(self.terms, terms))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        if isinstance(other, PolynomialBall):
            return self * (1 / other)
        return NotImplemented if _terms_of(other) is None else self * Ball(1 / arb_of(other))

    def __rtruediv__(self, other: Any) -> Any:
        """Return a number divided by this one, by the geometric series."""
        middle, apart = self._parted()
        size = flint.arb(1) if middle.contains(0) else (apart.arb / middle).abs_upper()
        if not size < 1:
            raise UndecidedError("a number that may be zero, or is far from its middle")
        ratio = apart * Ball(-1 / middle)
        total = power = PolynomialBall({(): flint.arb(1)})
        for _ in range(ORDER):
            power = power * ratio
            total = total + power
        rest = size ** (ORDER + 1) / (1 - size)
        return (total + Ball(flint.arb(0, 1) * rest)) * Ball(1 / middle) * other

    def __pow__(self, exponent: int) -> Any:
        if not isinstance(exponent, int):
            raise TypeError("a power of a polynomial needs an integer exponent")
        if exponent < 0:
            return 1 / self**-exponent
        return math.prod([self] * exponent, start=PolynomialBall({(): flint.arb(1)}))

    def __abs__(self) -> Any:
        value = self.arb
        return self if value >= 0 else -self if value <= 0 else Ball(abs(value))

    def _parted(self) -> tuple[Any, "PolynomialBall"]:
        """Return what does not follow the coordinates, and what does."""
        return self.terms.get((), flint.arb(0)), PolynomialBall({key: term for key, term in self.terms.items() if key})

    def through(self, function: Callable[[Any], Any]) -> Any:
        """Return a function of it, by its series about the middle; `function` takes Arb's series."""
        if function not in self.functions:
            self.functions[function] = self._series(function)
        return self.functions[function]

    def _series(self, function: Callable[[Any], Any]) -> Any:
        middle, apart = self._parted()
        coefficients = _series_about(middle, function)[:-1] + _series_about(self.arb, function)[-1:]
        total: Any = 0.0
        for coefficient in reversed(coefficients):  # the last is that of all that it may be
            total = total * apart + Ball(coefficient)
        return total


def _series_about(middle: Any, function: Callable[[Any], Any]) -> list[Any]:
    """Return the coefficients of a function's series about a number, up to `ORDER`."""
    found = function(flint.arb_series([middle, 1], prec=ORDER + 1)).coeffs()
    return [*found, *[flint.arb(0)] * (ORDER + 1 - len(found))]


def _terms_of(number: Any) -> Terms | None:
    """Return the terms of a number, None for what is none."""
    if isinstance(number, PolynomialBall):
        return number.terms
    return {(): arb_of(number)} if isinstance(number, int | float | Ball) else None


def repeated(terms: Terms, times: int) -> Terms:
    """Return matrices along the diagonal as many times."""
    return {key: _diagonal(term, times) for key, term in terms.items()}


def _diagonal(matrix: Any, times: int) -> Any:
    if times == 1:
        return matrix
    rows, zeros = matrix.tolist(), [0] * matrix.ncols()
    return flint.arb_mat([zeros * i + row + zeros * (times - 1 - i) for i in range(times) for row in rows])


def matrix_terms(rows: Sequence[Sequence[Any]]) -> Terms:
    """Return a matrix of numbers, balls and polynomials as a polynomial of matrices."""
    height, width = len(rows), len(rows[0]) if rows else 0
    entries: dict[Key, list[Any]] = {}
    for place, value in enumerate(value for row in rows for value in row):
        for key, term in (value.terms if isinstance(value, PolynomialBall) else {(): arb_of(value)}).items():
            if not term.is_zero():
                entries.setdefault(key, [flint.arb(0)] * (height * width))[place] = term
    return {key: flint.arb_mat(height, width, values) for key, values in entries.items()}


def at_corners(terms: Terms, places: Sequence[int]) -> Iterator[Any]:
    """Yield the middles of a polynomial of matrices with some coordinates at their ends, the others
    in the middle.

    The last of these coordinates is the fastest.
    """
    if not places:
        yield terms[()].mid()
        return
    even, odd = dict[Key, Any](), dict[Key, Any]()
    for key, term in terms.items():
        part, others = (odd, even)[key.count(places[0]) % 2 == 0], tuple(i for i in key if i != places[0])
        part[others] = part[others] + term.mid() if others in part else term.mid()
    for sign in (-1, 1):
        yield from at_corners(added(even, {key: term * sign for key, term in odd.items()}), places[1:])


def polynomial_exponential(rows: Sequence[Sequence[Any]], period: float) -> list[list[Any]]:
    """Return exp([[A, B], [0, 0]] period) of the rows [A B], which hold polynomials, by rows.

    Its series is summed for a part of the period, then squared. Raises `UndecidedError` for what is
    too large.
    """
    size = len(rows[0])
    square = [[*row] for row in rows] + [[0.0] * size for _ in range(size - len(rows))]
    units = [1.0] * size  # powers of two, by which a product is exact
    balance([float(arb_of(value).mid()) * period for row in square for value in row], size, units)
    scales = [[own / unit for own in units] for unit in units]
    pairs = (zip(row, by, strict=True) for row, by in zip(square, scales, strict=True))
    terms = matrix_terms([[value * scale for value, scale in row] for row in pairs])
    halvings = _halvings(terms, size, period)
    part, one = flint.arb(period) / 2**halvings, _unit(size)
    scaled = {key: term * part for key, term in terms.items()}
    total: Terms = {(): one}
    for order in range(_SERIES, 0, -1):
        total = added({(): one}, {key: term / order for key, term in product(scaled, total).items()})
    rest = flint.arb(0, 1) * flint.arb(_SMALL) ** (_SERIES + 1) / math.factorial(_SERIES)  # more than what is left out
    total = added(total, {(): flint.arb_mat([[rest] * size] * size)})
    for _ in range(halvings):
        total = product(total, total)
    return [
        [_entry({key: term[i, j] for key, term in total.items()}, 1.0 / scales[i][j]) for j in range(size)]
        for i in range(size)
    ]


def _halvings(terms: Terms, size: int, period: float) -> int:
    """Return how many halves of a period are to be taken until the norm of its matrix is small."""
    sizes = sum(_sizes_by_order(terms).values(), flint.arb_mat(size, size)) * flint.arb(period)
    norm = max(float(sum(row, flint.arb(0)).upper()) for row in sizes.tolist())
    if not norm < _LARGE:
        raise UndecidedError("a matrix exponential without bounds")
    return max(0, math.frexp(norm / _SMALL)[1])


def _unit(size: int) -> Any:
    return flint.arb_mat([[int(i == j) for j in range(size)] for i in range(size)])


def _entry(terms: Terms, scale: float) -> Any:
    moved = {key: term * scale for key, term in terms.items() if not term.is_zero()}
    return PolynomialBall(moved) if any(moved) else Ball(moved.get((), flint.arb(0)))
