"""Dual numbers: a value with its exact derivatives in any number of directions (Griewank and
Walther 2008, chapter 3).

    f(a + sum of s_i d_i) = f(a) + f'(a) sum of s_i d_i

`slopes` holds the slopes other than zero, by direction; a number that depends on nothing is plain.
Levels nest: the value and the slopes of a dual number of level 1 may be dual numbers of level 0,
which gives mixed second derivatives, such as those of a transition matrix by a parameter.

Quantisers count as their input, with the derivative one, in value too: `int`, `math.trunc`,
`round`, `//`, `>>`, `rounding.round_half_even` and `rounding.round_down` of a dual number. What
parameters alone move, as a carrier, is rounded by the rules of `rounding` as in the run. What is
counted with, `math.floor`, `math.ceil` and `rounding.nearest_integer`, is a plain number.
Comparisons are those of the values. Integers stay dual:
`& | ^` are known for 0 and -1, which take, keep or turn all bits, and raise TypeError elsewhere. A
register that wraps takes off a constant (`wrapped`).

Where a function has no finite derivative, such as the square root at 0, the slope is `UNDEFINED`,
which is not finite; what is multiplied by exactly 0 has lost it again.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from typing import Any

from proofmass.blocks.arithmetic.mantissa import Drop, Mantissa, dropped

Slopes = Mapping[Any, Any]  # by direction
_NONE: Slopes = {}
PARAMETERS, SIGNALS = 0, 1  # levels of the dual numbers
_NUMBERS = (int, float)  # a union of types would be made anew in each call
UNDEFINED = math.nan  # the slope at a corner, or where it is infinite
NO_SLOPE = "it has a corner here, or an infinite slope"
_BITS = "is an operation on the bits of a number that signals move"


_Error = Callable[[Any, Drop], Any]  # adds a rounding's error to a number
_ERROR: ContextVar[_Error | None] = ContextVar("error of a rounding", default=None)  # where numbers are whole
_TIES: ContextVar["Ties | None"] = ContextVar("comparisons of equal numbers", default=None)  # where they are counted


@contextmanager
def _holding(variable: ContextVar[Any], value: Any) -> Iterator[None]:
    """Give a variable a value meanwhile."""
    token = variable.set(value)
    try:
        yield
    finally:
        variable.reset(token)


def with_errors(of: _Error) -> AbstractContextManager[None]:
    """Take numbers for whole ones, and call `of(value, drop)` where they are rounded, in steps."""
    return _holding(_ERROR, of)


class Ties:
    """Counts comparisons of equal numbers that move apart; with a `side`, 1 or -1, they come out as a little later.

    All directions count alike: numbers move by the sum of their slopes, or against it.
    """

    def __init__(self, side: int = 0) -> None:
        self.side, self.found = side, 0


def with_ties(of: Ties) -> AbstractContextManager[None]:
    """Count ties meanwhile."""
    return _holding(_TIES, of)


class Dual(Mantissa):
    """A value and its slopes, a `Mantissa` too; `dual` leaves plain what has none."""

    __slots__ = ("level", "slopes", "value")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, value: Any, slopes: Slopes, level: int) -> None:
        self.value, self.slopes, self.level = value, slopes, level

    def __repr__(self) -> str:
        return f"Dual({self.value!r}, {dict(self.slopes)!r})"

    def __add__(self, other: Any) -> Any:
        if self.slopes and not isinstance(other, Dual):
            return Dual(self.value + other, self.slopes, self.level)
        level, a, slopes, b, others = _pair(self, other)
        return chained(level, a + b, (1.0, slopes), (1.0, others))

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        if self.slopes and not isinstance(other, Dual):
            return Dual(self.value - other, self.slopes, self.level)
        level, a, slopes, b, others = _pair(self, other)
        return chained(level, a - b, (1.0, slopes), (-1.0, others))

    def __rsub__(self, other: Any) -> Any:
        return (-self) + other

    def __mul__(self, other: Any) -> Any:
        if type(other) is int and other == 0:
            return 0  # without slopes a mantissa is an integer again, which can be shifted
        if type(other) is float and self.slopes:
            return chained(self.level, self.value * other, (other, self.slopes))
        level, a, slopes, b, others = _pair(self, other)
        return chained(level, a * b, (b, slopes), (a, others))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        level, a, slopes, b, others = _pair(self, other)
        ratio = a / b
        return chained(level, ratio, (1.0 / b, slopes), (-ratio / b, others))

    def __rtruediv__(self, other: Any) -> Any:
        ratio = other / self.value
        return chained(self.level, ratio, (-ratio / self.value, self.slopes))

    def __mod__(self, other: Any) -> Any:
        return self - other * (plain(self) // plain(other))

    def __rmod__(self, other: Any) -> Any:
        return other - self * (plain(other) // plain(self))

    __floordiv__ = __truediv__
    __rfloordiv__ = __rtruediv__

    def __pow__(self, exponent: int) -> Any:
        if not isinstance(exponent, int):
            raise TypeError("a power of a dual number needs an integer exponent")
        if exponent == 0:
            return plain(self) ** 0
        return chained(self.level, self.value**exponent, (exponent * self.value ** (exponent - 1), self.slopes))

    def __lshift__(self, bits: Any) -> Any:
        return self * (1 << _plain_integer(bits, "<<"))

    def __rshift__(self, bits: Any) -> Any:
        places = _plain_integer(bits, ">>")
        return self.monotone(lambda mantissa: mantissa >> places)

    def __rlshift__(self, other: Any) -> Any:
        raise TypeError(f"<< {_BITS}")

    def __rrshift__(self, other: Any) -> Any:
        raise TypeError(f">> {_BITS}")

    def __and__(self, mask: Any) -> Any:
        return self if _mask(mask, "&") else 0

    def __or__(self, mask: Any) -> Any:
        return -1 if _mask(mask, "|") else self

    def __xor__(self, mask: Any) -> Any:
        return -self - 1 if _mask(mask, "^") else self

    __rand__, __ror__, __rxor__ = __and__, __or__, __xor__

    # What a mantissa does in a way of its own: a rule of rounding divides, and a register holds what is in its range.

    def monotone(self, rule: Callable[[int], int]) -> Any:
        """Return the number unrounded, with a rule's error where errors are followed."""
        drop = dropped(rule)
        value, err = self / (1 << drop.bits), _ERROR.get()
        return err(value, drop) if err and drop.bits else value

    def held(self, low: int, high: int, expected: str) -> Any:
        """Return the number itself, if the register can hold it once it is rounded."""
        if not low - 1 < plain(self) < high + 1:
            raise OverflowError(f"{plain(self)} does not fit {expected}")
        return self

    def wrapped(self, low: int, high: int) -> Any:
        """Return the number less the whole turns of a register that wraps."""
        return self - (plain(self) - low) // (high - low + 1) * (high - low + 1)

    def left_over(self, whole: Any, scale: Any) -> Any:
        """Return scale self / whole: a search's rest is not rounded here. No length gives 0."""
        return scale * (self / whole) if plain(whole) else 0

    def __neg__(self) -> Any:
        return chained(self.level, -self.value, (-1.0, self.slopes))

    def __abs__(self) -> Any:
        if plain(self) == 0:
            return chained(self.level, abs(self.value), (UNDEFINED, self.slopes))
        return -self if plain(self) < 0 else self

    def __round__(self, digits: int | None = None) -> Any:
        return self

    def __bool__(self) -> bool:
        return bool(plain(self))

    def __eq__(self, other: object) -> bool:
        return bool(plain(self) == plain(other))

    def __lt__(self, other: Any) -> bool:
        return self._compared(other, bool(plain(self) < plain(other)), True)

    def __le__(self, other: Any) -> bool:
        return self._compared(other, bool(plain(self) <= plain(other)), True)

    def __gt__(self, other: Any) -> bool:
        return self._compared(other, bool(plain(self) > plain(other)), False)

    def __ge__(self, other: Any) -> bool:
        return self._compared(other, bool(plain(self) >= plain(other)), False)

    def _compared(self, other: Any, made: bool, if_less: bool) -> bool:
        ties = _TIES.get()
        if ties is None or plain(self) != plain(other):
            return made
        apart = sum(self.slopes.values()) - sum(slopes_of(other, self.level).values())
        ties.found += bool(apart)
        return (ties.side * apart < 0.0) == if_less if ties.side * apart else made


def dual(value: Any, slopes: Slopes, level: int = 0) -> Any:
    """A dual number, or the plain value where no slope is left.

    >>> x = dual(3.0, {"x": 1.0})
    >>> x * x + 2.0 * x
    Dual(15.0, {'x': 8.0})
    """
    return _without_nothing(value, dict(slopes), level)


def chained(level: int, value: Any, *terms: tuple[Any, Slopes]) -> Any:
    """The chain rule: a value whose slopes are the sum of factors times slopes; what is times 0 is nothing."""
    total: dict[Any, Any] = {}
    for factor, slopes in terms:
        if not slopes or (factor == 0.0 if type(factor) is float else _is_nothing(factor)):
            continue
        one = type(factor) is float and factor == 1.0
        moved = dict(slopes) if one else {key: factor * slope for key, slope in slopes.items()}
        if not total:
            total = moved
            continue
        for key, slope in moved.items():
            total[key] = total[key] + slope if key in total else slope
    return _without_nothing(value, total, level)


def _without_nothing(value: Any, slopes: dict[Any, Any], level: int) -> Any:
    """Return a dual number of slopes that are its own, or the plain value where none is left.

    A whole number that was not rounded stays dual, since a plain one has no bits to shift.
    """
    first = next(iter(slopes.values()), 0.0)
    try:
        nothing = not isinstance(first, _NUMBERS) or 0.0 in slopes.values()  # one pass in C
    except ArithmeticError:  # a ball leaves it undecided
        nothing = True
    for key in [key for key, slope in slopes.items() if _is_nothing(slope)] if nothing else ():
        del slopes[key]
    unrounded = not slopes and isinstance(value, float) and _ERROR.get() is not None
    return Dual(value, slopes, level) if slopes or unrounded else value


def _is_nothing(slope: Any) -> bool:
    """Return whether a slope is zero, and without slopes or bounds of its own."""
    return isinstance(slope, _NUMBERS) and slope == 0.0


def plain(number: Any) -> Any:
    """The value behind a number, whatever its slopes.

    >>> plain(dual(3.0, {"x": 1.0})), plain(2)
    (3.0, 2)
    """
    while isinstance(number, Dual):
        number = number.value
    return number


def with_plain(number: Any, value: Any) -> Any:
    """A number with another value behind it, and its slopes.

    >>> with_plain(dual(3.2, {"x": 1.0}), 3.0)
    Dual(3.0, {'x': 1.0})
    """
    if not isinstance(number, Dual):
        return value
    return Dual(with_plain(number.value, value), number.slopes, number.level)


def slopes_of(number: Any, level: int = 0) -> Slopes:
    """The slopes of a number on a level."""
    if isinstance(number, Dual) and number.level > level:
        return slopes_of(number.value, level)
    return number.slopes if isinstance(number, Dual) and number.level == level else _NONE


def value_of(number: Any, level: int = 0) -> Any:
    """The number without the slopes of a level and those above."""
    while isinstance(number, Dual) and number.level >= level:
        number = number.value
    return number


def _plain_integer(number: Any, operation: str) -> int:
    if not isinstance(number, int):
        raise TypeError(f"{operation} {_BITS}")
    return number


def _mask(mask: Any, operation: str) -> int:
    """Return a mask of all bits or none; any other takes a number apart, and is refused."""
    if not isinstance(mask, int) or mask not in (0, -1):
        raise TypeError(f"{operation} {_BITS}")
    return mask


def _pair(a: Dual, b: Any) -> tuple[int, Any, Slopes, Any, Slopes]:
    """Level, values and slopes of two numbers on the higher of their levels."""
    if not isinstance(b, Dual):
        return a.level, a.value, a.slopes, b, _NONE
    level = max(a.level, b.level)
    left, slopes = (a.value, a.slopes) if a.level == level else (a, _NONE)
    right, others = (b.value, b.slopes) if b.level == level else (b, _NONE)
    return level, left, slopes, right, others
