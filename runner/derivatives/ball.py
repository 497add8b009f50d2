"""Balls: real numbers that are known to lie in an interval. What is computed with them encloses
every value in it.

    [a] + [b] holds a + b for all a of [a] and b of [b]; so do products, quotients and elementary
    functions

Balls are Arb's (Johansson, IEEE Trans. Computers 66, 2017, 1281). A comparison that holds for some
values and not for others has no answer: it raises `UndecidedError`, and whoever asked takes a
smaller interval. There is no silent way to an ordinary number: `float` of a ball raises TypeError.

Functions of the library are within a unit in the last place of the exact ones; their balls hold
both.
"""

import math
import operator
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import flint
import numpy as np

from proofmass.blocks.arithmetic import elementary
from proofmass.runner.host.precision import precision

BITS = 96  # of the midpoints
UNIT = 2.0**-53  # largest relative rounding error of a double
UP = 1.0 + 2.0**-40  # more than the rounding of a sum of some thousand positive numbers
LEAST = 1e-290  # more than what underflow takes
LAST_PLACES = 2.0**-50  # more than a few units in the last place of a double


@contextmanager
def enclosing() -> Iterator[None]:
    """Count with balls of `BITS` bits, and in doubles without warnings of what has no bounds."""
    with precision(BITS), np.errstate(over="ignore", invalid="ignore"):
        yield


class UndecidedError(ArithmeticError):
    """A comparison or a count that is not the same for all numbers of a ball."""


def _operated(operation: Callable[[Any, Any], Any]) -> Callable[["Ball", Any], Any]:
    def operated(self: "Ball", other: Any) -> Any:
        if not is_number(other):
            return NotImplemented
        value = operation(self.arb, arb_of(other))
        if not value.is_finite():
            raise UndecidedError("a number without bounds")
        return Ball(value)

    return operated


class Ball:
    """A number in an interval.

    >>> x = ball(1.0, 2.0)
    >>> x * x - 0.5 < 4.0, x > 0.5
    (True, True)
    """

    __slots__ = ("arb",)
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, arb: Any) -> None:
        self.arb = arb

    def __repr__(self) -> str:
        mid, rad = (part.man_exp() for part in (self.arb.mid(), self.arb.rad()))
        return f"Ball({mid[0]} * 2^{mid[1]} +- {rad[0]} * 2^{rad[1]})"

    def ends(self) -> tuple[float, float]:
        """Return doubles at or below the lowest value, and at or above the highest."""
        low, high = float(self.arb.lower()), float(self.arb.upper())
        return math.nextafter(low, -math.inf), math.nextafter(high, math.inf)

    def followed_by(self, function: "Ball") -> "Ball":
        """Return a function of this ball as what it is: a ball that follows no factor."""
        return function

    def widened(self) -> "Ball":
        """Return the ball with the last places of each value as a further radius."""
        return Ball(self.arb * flint.arb(1, LAST_PLACES))

    __add__ = __radd__ = _operated(operator.add)
    __sub__ = _operated(operator.sub)
    __rsub__ = _operated(lambda a, b: b - a)
    __truediv__ = _operated(operator.truediv)
    __rtruediv__ = _operated(lambda a, b: b / a)
    _times = _operated(operator.mul)

    def __mul__(self, other: Any) -> Any:
        return 0.0 if isinstance(other, int | float) and other == 0.0 else self._times(other)

    __rmul__ = __mul__

    def __pow__(self, exponent: int) -> Any:
        if not isinstance(exponent, int):
            raise TypeError("a power of a ball needs an integer exponent")
        return Ball(self.arb**exponent)

    def __neg__(self) -> "Ball":
        return Ball(-self.arb)

    def __pos__(self) -> "Ball":
        return self

    def __abs__(self) -> "Ball":
        return Ball(abs(self.arb))

    def __floordiv__(self, other: Any) -> int:
        return whole((self / other).arb.floor()) if is_number(other) else NotImplemented

    def __rfloordiv__(self, other: Any) -> int:
        return whole((other / self).arb.floor())

    def __mod__(self, other: Any) -> Any:
        return self - other * (self // other) if is_number(other) else NotImplemented

    def __floor__(self) -> int:
        return whole(self.arb.floor())

    def __ceil__(self) -> int:
        return whole(self.arb.ceil())

    def __trunc__(self) -> int:
        return self.__floor__() if self >= 0 else self.__ceil__()

    __int__ = __trunc__

    def __round__(self, digits: int | None = None) -> int:
        if digits is not None:
            raise TypeError("a ball is rounded to whole numbers alone")
        nearest = whole((self.arb + 0.5).floor())
        if nearest != whole((self.arb - 0.5).ceil()):
            raise UndecidedError("a number in the middle between two whole ones")
        return nearest

    def __bool__(self) -> bool:
        return self != 0

    def __eq__(self, other: object) -> bool:
        if not is_number(other):  # a dual number has the answer
            return NotImplemented
        b = arb_of(other)
        if self.arb.is_exact() and b.is_exact():
            return bool(self.arb == b)
        return not _decided(not self.arb.overlaps(b), False)

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __lt__(self, other: Any) -> bool:
        if not is_number(other):
            return NotImplemented
        b = arb_of(other)
        return _decided(bool(self.arb < b), bool(self.arb >= b))

    def __le__(self, other: Any) -> bool:
        if not is_number(other):
            return NotImplemented
        b = arb_of(other)
        return _decided(bool(self.arb <= b), bool(self.arb > b))

    def __gt__(self, other: Any) -> bool:
        return not self <= other

    def __ge__(self, other: Any) -> bool:
        return not self < other


def ball(low: float, high: float) -> Ball:
    """Return the ball of an interval: the least that holds both ends."""
    return Ball(flint.arb(low).union(flint.arb(high)))


def is_number(of: object) -> bool:
    """Return whether it is a ball or a plain number."""
    return isinstance(of, int | float | Ball)


def is_zero(number: Any) -> bool:
    """Return whether a ball or a plain number is zero for certain."""
    return bool(number.arb.is_zero()) if isinstance(number, Ball) else number == 0.0


def arb_of(number: Any) -> Any:
    """Return a number as Arb's; doubles and integers are exact. Raises TypeError for others."""
    if isinstance(number, Ball):
        return number.arb
    if isinstance(number, flint.arb):
        return number
    if isinstance(number, int | float):
        return flint.arb(number)
    raise TypeError(f"a {type(number).__name__} cannot be a ball")


def double_of(number: Any) -> tuple[float, float]:
    """Return the double nearest to a number, and how far it may be off."""
    if type(number) is float:
        return number, 0.0
    value = arb_of(number)
    middle = float(value.mid())
    return middle, float((value - middle).abs_upper()) * UP


def whole(number: Any) -> int:
    """Return the only whole number of one of Arb's; raises `UndecidedError`."""
    unique = number.unique_fmpz()
    if unique is None:
        raise UndecidedError("a count that is not the same everywhere")
    return int(unique)


def _decided(holds: bool, fails: bool) -> bool:
    if holds == fails:
        raise UndecidedError("a comparison that holds for some values and not for others")
    return holds


# -- functions -------------------------------------------------------------------------------------

_METHODS = {  # Arb's methods of elementary functions
    "exp": (math.exp, elementary.exponential),
    "expm1": (math.expm1, elementary.exponential_less_one),
    "log": (math.log, elementary.logarithm, elementary.logarithm_of_fraction),
    "log1p": (math.log1p, elementary.logarithm_of_one_plus),
    "sin": (math.sin, elementary.sine),
    "cos": (math.cos, elementary.cosine),
    "tan": (math.tan, elementary.tangent),
    "asin": (math.asin, elementary.arcsine),
    "acos": (math.acos, elementary.arccosine),
    "atan": (math.atan, elementary.arctangent),
    "sinh": (math.sinh, elementary.hyperbolic_sine),
    "cosh": (math.cosh, elementary.hyperbolic_cosine),
    "tanh": (math.tanh, elementary.hyperbolic_tangent),
    "asinh": (math.asinh,),
    "acosh": (math.acosh,),
    "atanh": (math.atanh,),
    "erf": (math.erf,),
    "erfc": (math.erfc,),
    "sqrt": (math.sqrt,),
}
_OF_ONE: dict[Any, Callable[[Any], Any]] = {
    function: operator.methodcaller(name) for name, functions in _METHODS.items() for function in functions
}
_OF_ONE |= {
    math.cbrt: lambda x: x.root(3) if x > 0 else -((-x).root(3)),
    math.exp2: lambda x: (x * flint.arb.const_log2()).exp(),
    math.log2: lambda x: x.log() / flint.arb.const_log2(),
    elementary.binary_logarithm: lambda x: x.log() / flint.arb.const_log2(),
    math.log10: lambda x: x.log() / flint.arb.const_log10(),
    elementary.decimal_logarithm: lambda x: x.log() / flint.arb.const_log10(),
    math.degrees: lambda x: x * 180 / flint.arb.pi(),
    math.radians: lambda x: x * flint.arb.pi() / 180,
    elementary.sine_of_turns: lambda x: (2 * x).sin_pi(),
    elementary.cosine_of_turns: lambda x: (2 * x).cos_pi(),
}
_WIDE = 2.0**-10  # radius from which a function of both ends is narrower than one of the middle, with its slope
_MONOTONE = frozenset(
    function
    for name in ("exp", "expm1", "log", "log1p", "asin", "acos", "atan", "sinh", "tanh", "asinh", "erf", "erfc", "sqrt")
    for function in _METHODS[name]
)
_OF_TWO: dict[Any, Callable[[Any, Any], Any]] = {
    math.atan2: flint.arb.atan2,
    elementary.arctangent2: flint.arb.atan2,
    math.pow: lambda x, y: x**y,
    elementary.power: lambda x, y: x**y,
    math.hypot: lambda x, y: (x * x + y * y).sqrt(),
    elementary.hypotenuse: lambda x, y: (x * x + y * y).sqrt(),
}


def of_balls(function: Callable[..., Any], *numbers: Any) -> Any:
    """Return an elementary function of numbers, one of which is a ball; raises `UndecidedError` outside its domain."""
    known = _OF_ONE if len(numbers) == 1 else _OF_TWO
    if function not in known:
        raise UndecidedError(f"{function.__name__} has no ball")
    arbs = [*map(arb_of, numbers)]
    value = known[function](*arbs)
    if function in _MONOTONE and arbs[0].rad() > _WIDE:
        value = _OF_ONE[function](arbs[0].lower()).union(_OF_ONE[function](arbs[0].upper()))
    if not value.is_finite():
        raise UndecidedError(f"{function.__name__} of numbers that it has no value for")
    found: Ball = Ball(value).widened()
    for number in numbers:
        found = number.followed_by(found) if isinstance(number, Ball) else found
    return found


def of_series(value: Callable[[Any], Any], slope: Callable[[Any], Any], of: Any) -> Any:
    """Return a function of a power series, by its value at the first coefficient and its slope.

    `of` is Arb's: f(u) = f(u_0) + the integral of f'(u) u'. Raises `UndecidedError` outside its domain.
    """
    first = flint.arb_series([arb_of(value(Ball(of[0])))], prec=of.prec)
    if of.prec == 1:
        return first
    shorter = flint.arb_series(of.coeffs(), prec=of.prec - 1)
    try:
        return first + (slope(shorter) * flint.arb(1, LAST_PLACES) * of.derivative()).integral()
    except (ZeroDivisionError, ValueError):
        raise UndecidedError("a function without a slope") from None


def ball_exponential(rows: Sequence[Sequence[Any]], period: float) -> list[list[Any]]:
    """Return exp([[A, B], [0, 0]] period) of the rows [A B], which may hold balls, by rows; raises `UndecidedError`."""
    size = len(rows[0])
    square = [[arb_of(value) * period for value in row] for row in rows]
    square += [[flint.arb(0)] * size for _ in range(size - len(rows))]
    exponential: Any = flint.arb_mat(square).exp()
    entries: list[list[Any]] = exponential.tolist()
    if not all(value.is_finite() for row in entries for value in row):
        raise UndecidedError("a matrix exponential without bounds")
    return [[Ball(value) for value in row] for row in entries]
