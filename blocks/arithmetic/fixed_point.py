"""Fixed-point numbers: an integer mantissa with a number of fraction bits; value = mantissa / 2**fraction.

`+ - *`, negation, shifts and comparisons are exact: the result has as many bits as it needs. Bits
are lost in one place only, where the author writes `value.to(format, rounding, overflow)`:

    total = (x.total + c.gain * error).to(TOTAL, "half_up", "saturate")

Every rule is written in integer operators alone. The mantissa may therefore be a Python integer,
which is the reference, or a `Mantissa` such as the signal of a trace, from which the compiled code
is made: both follow the same lines. A mantissa has no unit; a port's unit belongs to the value.
"""

import operator
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from fractions import Fraction
from typing import Any, Literal, cast, get_args

from proofmass.blocks.arithmetic.fixed_format import Fixed
from proofmass.blocks.arithmetic.mantissa import (
    Condition,
    Mantissa,
    Rounding,
    WholeNumber,
    held,
    maximum,
    minimum,
    rounded,
    selected,
    wrapped,
)

__all__ = [
    "Fixed", "FixedValue", "Overflow", "Rounding", "clip", "counting_overflows", "fixed", "stored", "where", "wrap",
]  # fmt: skip

Overflow = Literal["saturate", "wrap", "refuse"]
_OVERFLOWS = get_args(Overflow)


class OverflowCount:
    """Count of the casts that saturated or wrapped: `total`. `lost` is nonzero whenever `total` is;
    it is cheaper.

    While a step is traced they are signals; with `refusals` so is `refused`, not 0 where a cast
    refuses.
    """

    def __init__(self, refusals: bool) -> None:
        self.total: WholeNumber = 0
        self.lost: WholeNumber = 0
        self.refused: WholeNumber = 0
        self.refusals = refusals


_counting: ContextVar[OverflowCount | None] = ContextVar("_counting", default=None)


@contextmanager
def counting_overflows(*, refusals: bool = False) -> Iterator[OverflowCount]:
    """Count the casts that saturate or wrap inside the `with` block, of both arms where `where` chooses one.

    >>> with counting_overflows() as overflows:
    ...     FixedValue(300, 4).to(Fixed(8, 4))
    FixedValue(127, 4)
    >>> overflows.total
    1
    """
    count = OverflowCount(refusals)
    token = _counting.set(count)
    try:
        yield count
    finally:
        _counting.reset(token)


def _comparison(compare: Callable[[Any, Any], Any]) -> Any:
    """Return the operator that compares mantissas at one fraction."""

    def compared(self: "FixedValue", other: Any) -> Any:
        a, b, _ = _aligned(self, other)
        return compare(a, b)

    return compared


class FixedValue:
    """A number mantissa / 2**fraction with exact arithmetic; integers mix in, floats do not (see `fixed`)."""

    __slots__ = ("fraction", "mantissa")

    def __init__(self, mantissa: WholeNumber, fraction: int = 0) -> None:
        self.mantissa = mantissa
        self.fraction = fraction

    def to(self, format: Fixed, rounding: Rounding = "half_even", overflow: Overflow = "saturate") -> "FixedValue":
        """The value in a format: rounded to its steps, then brought into its range.

        `half_even` and `half_up` take the nearest step, a tie to the even mantissa or upwards;
        `floor` drops bits; `toward_zero` drops bits of the magnitude. `wrap` keeps the low bits;
        `refuse` raises OverflowError.
        """
        mantissa = rounded(self.mantissa, self.fraction - format.fraction, rounding)
        return FixedValue(_fitted(mantissa, format, overflow), format.fraction)

    def __add__(self, other: Any) -> "FixedValue":
        a, b, fraction = _aligned(self, other)
        return FixedValue(a + b, fraction)

    def __radd__(self, other: Any) -> "FixedValue":
        return _lifted(other) + self

    def __sub__(self, other: Any) -> "FixedValue":
        a, b, fraction = _aligned(self, other)
        return FixedValue(a - b, fraction)

    def __rsub__(self, other: Any) -> "FixedValue":
        return _lifted(other) - self

    def __mul__(self, other: Any) -> "FixedValue":
        other = _lifted(other)
        return FixedValue(self.mantissa * other.mantissa, self.fraction + other.fraction)

    def __rmul__(self, other: Any) -> "FixedValue":
        return _lifted(other) * self

    def __truediv__(self, other: Any) -> "FixedValue":
        raise TypeError("a quotient has no exact fixed-point value: multiply by a constant reciprocal")

    __rtruediv__ = __floordiv__ = __rfloordiv__ = __mod__ = __rmod__ = __truediv__

    def __neg__(self) -> "FixedValue":
        return FixedValue(-self.mantissa, self.fraction)

    def __pos__(self) -> "FixedValue":
        return self

    def __abs__(self) -> "FixedValue":
        return where(self.mantissa < 0, -self, self)  # type: ignore[no-any-return]

    def __lshift__(self, places: int) -> "FixedValue":
        """Times 2**places: the binary point moves, the mantissa stays, nothing is lost."""
        return FixedValue(self.mantissa, self.fraction - _constant_shift(places))

    def __rshift__(self, places: int) -> "FixedValue":
        """Divided by 2**places: the binary point moves, the mantissa stays, nothing is lost."""
        return FixedValue(self.mantissa, self.fraction + _constant_shift(places))

    __lt__, __le__ = _comparison(operator.lt), _comparison(operator.le)
    __gt__, __ge__ = _comparison(operator.gt), _comparison(operator.ge)
    __eq__, __ne__ = _comparison(operator.eq), _comparison(operator.ne)
    __hash__ = None  # type: ignore[assignment]  # equal values may have different mantissas

    def __bool__(self) -> bool:
        return bool(self.mantissa != 0)

    @property
    def value(self) -> Fraction:
        """The number itself; only where the mantissa is a Python integer."""
        return Fraction(cast(int, self.mantissa)) / Fraction(2) ** self.fraction

    def __float__(self) -> float:
        return float(self.value)

    def __repr__(self) -> str:
        return f"FixedValue({self.mantissa}, {self.fraction})"


def fixed(value: int | float | Fraction, format: Fixed, rounding: Rounding | Literal["exact"] = "exact") -> FixedValue:
    """A constant in a format. Raises ValueError for a value that does not fit, or lies between
    steps with no rounding.

    >>> fixed(0.75, Fixed(8, 4)), fixed(0.1, Fixed(16, 12), "half_even")
    (FixedValue(12, 4), FixedValue(410, 12))
    """
    try:
        scaled = Fraction(value) * Fraction(2) ** format.fraction
    except (OverflowError, ValueError):
        raise ValueError(f"{format!r} cannot hold {value}") from None
    if rounding == "exact" and scaled.denominator != 1:
        raise ValueError(f'{value} is not a multiple of {format.resolution}: say a rounding, as in "half_even"')
    # Two bits below the step, the lowest set where anything follows, are enough for every rule of rounding.
    below, left = divmod(scaled.numerator * 4, scaled.denominator)
    mantissa = rounded(below | (left != 0), 2, "floor" if rounding == "exact" else rounding)
    if not format.lowest <= mantissa <= format.highest:
        raise ValueError(f"{value} does not fit {format.with_range}")
    return FixedValue(mantissa, format.fraction)


def where(condition: Condition, chosen: Any, otherwise: Any) -> Any:
    """`chosen` where the condition holds, else `otherwise`; both are computed, as hardware does.

    A plain `if` does the same; this one stays cheap where many follow each other. Values are
    FixedValue or integers.
    """
    if isinstance(chosen, FixedValue) or isinstance(otherwise, FixedValue):
        a, b, fraction = _aligned(_lifted(chosen), otherwise)
        return FixedValue(where(condition, a, b), fraction)
    if isinstance(condition, FixedValue):
        raise TypeError("a condition is a comparison: write value != 0")
    return selected(condition, chosen, otherwise)


def clip(value: Any, low: Any, high: Any) -> Any:
    """The value held between two bounds, `high` where they cross; FixedValue or integers, exact.

    >>> clip(FixedValue(100, 4), -1, 2)
    FixedValue(32, 4)
    """
    if any(isinstance(each, FixedValue) for each in (value, low, high)):
        values = [_lifted(each) for each in (value, low, high)]
        fraction = max(each.fraction for each in values)
        value, low, high = (each.mantissa << (fraction - each.fraction) for each in values)
        return FixedValue(clip(value, low, high), fraction)
    return minimum(maximum(value, low), high)


def wrap(value: Any, format: Fixed) -> Any:
    """The low bits of a value, as two's complement of the format's width; an integer, or a
    FixedValue of its fraction.

    Unlike `.to(format, overflow="wrap")` this is meant, and is not counted as an overflow.

    >>> wrap(16, Fixed(4, 0, signed=False)), wrap(9, Fixed(4))
    (0, -7)
    """
    if isinstance(value, FixedValue):
        if value.fraction != format.fraction:
            raise TypeError(f"{value.fraction} fraction bits do not wrap in {format!r}: bring them there with .to()")
        return FixedValue(wrap(value.mantissa, format), format.fraction)
    return wrapped(value, format.lowest, format.highest)


def stored(value: FixedValue | WholeNumber, format: Fixed) -> Any:
    """The mantissa that a register of a format holds for a value, which must have a place in it.

    Raises TypeError for a value with more fraction bits, OverflowError for one outside the range.
    """
    value = _lifted(value)
    if value.fraction > format.fraction:
        raise TypeError(f"{value.fraction} fraction bits do not go into {format!r}: round with .to({format!r})")
    return held(value.mantissa << (format.fraction - value.fraction), format)


def _fitted(mantissa: WholeNumber, format: Fixed, overflow: Overflow) -> Any:
    if overflow not in _OVERFLOWS:
        raise TypeError(f"overflow is one of {', '.join(_OVERFLOWS)}, not {overflow!r}")
    count = _counting.get()
    if overflow == "refuse" and (isinstance(mantissa, int) or count is None or not count.refusals):
        return held(mantissa, format)
    if count is not None and overflow != "refuse":
        count.total = count.total + ((mantissa < format.lowest) | (mantissa > format.highest))
    fitted = wrap(mantissa, format) if overflow == "wrap" else clip(mantissa, format.lowest, format.highest)
    if count is not None and overflow == "refuse":
        count.refused = count.refused | (fitted ^ mantissa)
    elif count is not None:
        count.lost = count.lost | (fitted ^ mantissa)
    return fitted


# -- operands --------------------------------------------------------------------------------------


def _lifted(value: Any) -> FixedValue:
    if isinstance(value, FixedValue):
        return value
    if isinstance(value, int | Mantissa):
        return FixedValue(value, 0)
    raise TypeError(f"a {type(value).__name__} has no fixed-point format: write fixed(value, format, rounding)")


def _aligned(a: FixedValue, other: Any) -> tuple[WholeNumber, WholeNumber, int]:
    """Both mantissas at the finer of the two fractions, and that fraction."""
    b = _lifted(other)
    if a.fraction == b.fraction:
        return a.mantissa, b.mantissa, a.fraction
    if a.fraction < b.fraction:
        return a.mantissa << (b.fraction - a.fraction), b.mantissa, b.fraction
    return a.mantissa, b.mantissa << (a.fraction - b.fraction), a.fraction


def _constant_shift(places: int) -> int:
    if not isinstance(places, int):
        raise TypeError("the binary point moves by a constant number of places: shift the mantissa, or multiply")
    return places
