"""Polynomials of a few coordinates as numbers that blocks are called with, and matrices of them.

A ball alone forgets which parameters it came from, so that products of many of them grow wide; a
polynomial is off by the terms that are left out (`taylor_model`). Functions of one number are their
series about the middle, with the next term of all that the number may be.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

import flint
import numpy as np

from proofmass.runner.continuous.exact_hold import balance
from proofmass.runner.derivatives.ball import LAST_PLACES, UNIT, UP, Ball, UndecidedError, arb_of, double_of
from proofmass.runner.derivatives.taylor_model import TaylorModel, monomials, order_kept, stacked

_SERIES, _SMALL = 24, 0.5  # terms of an exponential, and the norm up to which these leave less than the last places
_LARGE = 2.0**20  # norm of what is no exponential of a tick


class PolynomialBall(Ball):
    """A number that follows coordinates.

    >>> x = PolynomialBall.coordinate(1.0, 2.0, 0)
    >>> (x * x - x * x).ends()[1] < 1e-12
    True
    """

    __slots__ = ("functions", "model")

    def __init__(self, model: TaylorModel) -> None:
        self.model = model
        self.functions: dict[Any, Any] = {}  # asked for: a slope asks for the value again

    @classmethod
    def coordinate(cls, low: float, high: float, number: int) -> Any:
        """Return the coordinate of a number, between two ends."""
        if not low < high:
            return Ball(flint.arb(low))
        (middle, off), (half, apart) = map(double_of, ((flint.arb(low) + high) / 2, (flint.arb(high) - low) / 2))
        return cls.about(middle, half, number).off_by(off + apart)

    @classmethod
    def about(cls, middle: float, half: float, number: int) -> "PolynomialBall":
        """Return a coordinate's number about a middle, as far as half a side."""
        exponents = np.zeros((2, number + 1))
        exponents[1, number] = 1
        return cls(TaylorModel(monomials(exponents), np.array([middle, half]), 0.0))

    def off_by(self, radius: float) -> "PolynomialBall":
        """Return the number within a further radius."""
        return PolynomialBall(self.model.within(self.model.radius + radius))

    @property
    def arb(self) -> Any:
        """All that it may be, as one of Arb's."""
        middle, apart = self.model.ends()
        if not math.isfinite(middle) or not math.isfinite(apart):
            raise UndecidedError("a number without bounds")
        return flint.arb(middle, apart)

    @property
    def middles(self) -> "PolynomialBall":
        """The polynomial alone, without what is not known of it."""
        return PolynomialBall(self.model.middles)

    def __repr__(self) -> str:
        model = self.model
        terms = dict(zip(map(tuple, model.of.exponents.tolist()), model.coefficients.tolist(), strict=True))
        return f"PolynomialBall({terms} +- {float(model.radius)})"

    def widened(self) -> "PolynomialBall":
        """Return the number with the last places of each value as a further radius."""
        return self.off_by(LAST_PLACES * self.model.whole)

    def __add__(self, other: Any) -> Any:
        if isinstance(other, PolynomialBall):
            return PolynomialBall(self.model + other.model)
        return PolynomialBall(self.model.moved(*double_of(other))) if _is_constant(other) else NotImplemented

    __radd__ = __add__

    def __neg__(self) -> "PolynomialBall":
        return PolynomialBall(-self.model)

    def __sub__(self, other: Any) -> Any:
        return other.taken_off(self) if isinstance(other, WholeTurns) else self + -other

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, PolynomialBall):
            return PolynomialBall(self.model * other.model)
        if isinstance(other, int | float) and other == 0.0:
            return 0.0
        return PolynomialBall(self.model.scaled(*double_of(other))) if _is_constant(other) else NotImplemented

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        if isinstance(other, PolynomialBall):
            return self * (1 / other)
        return self * Ball(1 / arb_of(other)) if _is_constant(other) else NotImplemented

    def __rtruediv__(self, other: Any) -> Any:
        """Return a number divided by this one."""
        if self.arb.contains(0):
            raise UndecidedError("a number that may be zero")
        inverse = self.through(_inverse)
        inverse.functions[_inverse] = self
        return inverse if isinstance(other, int | float) and other == 1.0 else inverse * other

    def __pow__(self, exponent: int) -> Any:
        if not isinstance(exponent, int):
            raise TypeError("a power of a polynomial needs an integer exponent")
        if exponent < 0:
            return 1 / self**-exponent
        return math.prod([self] * exponent, start=PolynomialBall(TaylorModel.constant(1.0)))

    def __abs__(self) -> Any:
        value = self.arb
        return self if value >= 0 else -self if value <= 0 else Ball(abs(value))

    def nearest_integer(self) -> Any:
        """Return the whole number nearest to it; where that is not known, one that can be taken off."""
        try:
            return float(round(self))
        except UndecidedError:
            return WholeTurns(self)

    def through(self, function: Callable[[Any], Any]) -> Any:
        """Return a function of it, by its series about the middle; `function` takes Arb's series."""
        if function not in self.functions:
            self.functions[function] = self._series(function)
        return self.functions[function]

    def _series(self, function: Callable[[Any], Any]) -> Any:
        middle = float(self.model.coefficients[0])
        apart, order = self - middle, order_kept(self.model.of.width)
        coefficients = _series_about(flint.arb(middle), function, order)
        beyond = _series_about(self.arb, function, order + 1)[-1] * flint.arb(apart.model.whole) ** (order + 1)
        total: Any = Ball(coefficients[-1])
        for coefficient in reversed(coefficients[:-1]):
            total = total * apart + Ball(coefficient)
        return total.off_by(double_of(beyond.abs_upper())[0] * UP)


class WholeTurns(Ball):
    """The whole number nearest to a number, where that is not known: taken off, it leaves the number but for turns."""

    __slots__ = ("of",)

    def __init__(self, of: "PolynomialBall | Turned") -> None:
        self.of = of

    @property
    def arb(self) -> Any:
        """Raises `UndecidedError`."""
        raise UndecidedError("a number in the middle between two whole ones")

    def taken_off(self, number: Any) -> Any:
        """Return what is left of the number: no turn is missing where only one leaves it between -1/2 and 1/2."""
        if number is not self.of or (isinstance(number, Turned) and number.turn != 1.0):
            raise UndecidedError("a whole number that is not known")
        left = number.of if isinstance(number, Turned) else number
        left = left - float(round(left.model.coefficients[0]))
        low, high = left.ends()
        return left if isinstance(number, Turned) and -0.5 < low <= high < 0.5 else Turned(left)


class Turned(Ball):
    """A number that is known but for a number of turns: functions that come round with a turn are known of it."""

    __slots__ = ("of", "turn")

    def __init__(self, of: PolynomialBall, turn: float = 1.0) -> None:
        self.of, self.turn = of, turn

    @property
    def arb(self) -> Any:
        """Raises `UndecidedError`."""
        raise UndecidedError("a number that is known but for whole turns")

    def __add__(self, other: Any) -> Any:
        return Turned(self.of + other, self.turn)

    def __sub__(self, other: Any) -> Any:
        return other.taken_off(self) if isinstance(other, WholeTurns) else Turned(self.of - other, self.turn)

    def __mul__(self, other: Any) -> Any:
        return Turned(self.of * other, self.turn * other) if isinstance(other, float) else super().__mul__(other)

    __rmul__ = __mul__

    def nearest_integer(self) -> WholeTurns:
        """Return the whole number nearest to it, which is not known."""
        return WholeTurns(self)


def _series_about(middle: Any, function: Callable[[Any], Any], order: int) -> list[Any]:
    """Return the coefficients of a function's series about a number, up to an order."""
    found = function(flint.arb_series([middle, 1], prec=order + 1)).coeffs()
    return [*found, *[flint.arb(0)] * (order + 1 - len(found))]


def _inverse(series: Any) -> Any:
    return 1 / series


def _is_constant(number: Any) -> bool:
    return isinstance(number, int | float | Ball)


def model_of(rows: Sequence[Sequence[Any]]) -> TaylorModel:
    """Return a matrix of numbers, balls and polynomials."""
    models = [_model(value) for row in rows for value in row]
    return stacked(models, (len(rows), len(rows[0]) if rows else 0))


def _model(number: Any) -> TaylorModel:
    return number.model if isinstance(number, PolynomialBall) else TaylorModel.constant(*double_of(number))


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
    matrix = model_of([[value * scale for value, scale in row] for row in pairs])
    halvings = _halvings(matrix, period)
    scaled, unit = matrix.scaled(math.ldexp(period, -halvings)), np.eye(size)
    total = TaylorModel.constant(unit)
    for order in range(_SERIES, 0, -1):
        total = (scaled @ total).scaled(1.0 / order, UNIT / order).moved(unit)
    rest = _SMALL ** (_SERIES + 1) / math.factorial(_SERIES)  # more than what is left out
    total = total.within(total.radius + rest)
    for _ in range(halvings):
        total = total @ total
    return [[_entry(total[i, j].scaled(1.0 / scales[i][j])) for j in range(size)] for i in range(size)]


def _halvings(matrix: TaylorModel, period: float) -> int:
    """Return how many halves of a period are to be taken until the norm of its matrix is small."""
    norm = float((matrix.whole * period).sum(axis=1).max()) * UP
    if not norm < _LARGE:
        raise UndecidedError("a matrix exponential without bounds")
    return max(0, math.frexp(norm / _SMALL)[1])


def _entry(model: TaylorModel) -> Any:
    number = PolynomialBall(model.pruned)
    return number if number.model.of.last else Ball(number.arb)
