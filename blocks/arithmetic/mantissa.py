"""Mantissas of fixed-point values: Python integers, or what stands for one while a step is traced,
proved or differentiated.

The rules below are written in integer operators alone, so that all of them follow the same lines.
What a `Mantissa` does in a way of its own, as a signal that cannot decide a comparison, it is asked
for by name.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args

from proofmass.blocks.arithmetic.fixed_format import Fixed

Rounding = Literal["half_even", "half_up", "floor", "toward_zero"]
_ROUNDINGS = get_args(Rounding)
_LARGE = 200  # bits of a number by which a rule shows how many it drops


class Mantissa:
    """A stand-in for a Python integer, with its operators: it stands for every value that the
    integer could have.

    A class that derives from it has these operators, and says for itself what it does otherwise
    than others. The choices are those of one that decides its comparisons. No metaclass makes
    `isinstance` slow.
    """

    __slots__ = ()

    if TYPE_CHECKING:

        def __add__(self, other: Any, /) -> Any: ...
        def __radd__(self, other: Any, /) -> Any: ...
        def __sub__(self, other: Any, /) -> Any: ...
        def __rsub__(self, other: Any, /) -> Any: ...
        def __mul__(self, other: Any, /) -> Any: ...
        def __rmul__(self, other: Any, /) -> Any: ...
        def __lshift__(self, other: Any, /) -> Any: ...
        def __rshift__(self, other: Any, /) -> Any: ...
        def __and__(self, other: Any, /) -> Any: ...
        def __rand__(self, other: Any, /) -> Any: ...
        def __or__(self, other: Any, /) -> Any: ...
        def __ror__(self, other: Any, /) -> Any: ...
        def __xor__(self, other: Any, /) -> Any: ...
        def __rxor__(self, other: Any, /) -> Any: ...
        def __lt__(self, other: Any, /) -> Any: ...
        def __le__(self, other: Any, /) -> Any: ...
        def __gt__(self, other: Any, /) -> Any: ...
        def __ge__(self, other: Any, /) -> Any: ...
        def __neg__(self) -> Any: ...

    def __pos__(self) -> Any:
        return self

    def __invert__(self: Any) -> Any:
        return -1 - self

    def select(self, chosen: Any, otherwise: Any) -> Any:
        """`chosen` where it is not 0, else `otherwise`."""
        return chosen if self else otherwise

    def minimum(self: Any, other: Any) -> Any:
        """The smaller of the two."""
        return self if self <= other else other

    def maximum(self: Any, other: Any) -> Any:
        """The greater of the two."""
        return self if self >= other else other

    def wrapped(self, low: int, high: int) -> Any:
        """The low bits, as two's complement where `low` is negative."""
        return low_bits(self, low, high)

    def monotone(self, rule: Callable[[Any], Any]) -> Any:
        """The value of a rule that never decreases."""
        return rule(self)

    def held(self, low: int, high: int, expected: str) -> Any:
        """Return the value itself; it is refused if its bounds exceed those `expected`."""
        raise NotImplementedError

    def cut(self) -> Any:
        """The number itself: a cut changes no value."""
        return self

    def left_over(self, whole: Any, scale: Any) -> Any:
        """Return 0: what is below the last step is not computed."""
        return 0


WholeNumber: TypeAlias = int | Mantissa
Condition: TypeAlias = bool | int | Mantissa


def selected(condition: Condition, chosen: WholeNumber, otherwise: WholeNumber) -> Any:
    """`chosen` where the condition holds, else `otherwise`."""
    if isinstance(condition, int):
        return chosen if condition else otherwise
    return condition.select(chosen, otherwise)


def minimum(a: WholeNumber, b: WholeNumber) -> Any:
    """The smaller of two."""
    if isinstance(a, int):
        return min(a, b) if isinstance(b, int) else b.minimum(a)
    return a.minimum(b)


def maximum(a: WholeNumber, b: WholeNumber) -> Any:
    """The greater of two."""
    if isinstance(a, int):
        return max(a, b) if isinstance(b, int) else b.maximum(a)
    return a.maximum(b)


def left_over(part: WholeNumber, whole: WholeNumber, scale: WholeNumber) -> Any:
    """The rest of a search by signs, scale part / whole: it is below the last step, so it counts as 0.

    The result of the search is a sum of constants, which has no slope. Where a graph is linearised
    the rest brings it.
    """
    return 0 if isinstance(part, int) else part.left_over(whole, scale)


def held(mantissa: WholeNumber, format: Fixed) -> Any:
    """The mantissa, which must be one of the format; raises OverflowError."""
    if not isinstance(mantissa, int):
        return mantissa.held(format.lowest, format.highest, format.with_range)
    if not format.lowest <= mantissa <= format.highest:
        raise OverflowError(f"{format.shown(mantissa)} does not fit {format.with_range}")
    return mantissa


def wrapped(mantissa: WholeNumber, low: int, high: int) -> Any:
    """The low bits of a mantissa, as two's complement where `low` is negative.

    >>> wrapped(16, 0, 15), wrapped(9, -8, 7)
    (0, -7)
    """
    return low_bits(mantissa, low, high) if isinstance(mantissa, int) else mantissa.wrapped(low, high)


def low_bits(mantissa: Any, low: int, high: int) -> Any:
    """Return the same as `wrapped`, in operators."""
    bits, sign = mantissa & (high - low), -low
    return (bits ^ sign) - sign if sign else bits


def rounded(mantissa: WholeNumber, dropped: int, rounding: Rounding) -> Any:
    """mantissa / 2**dropped as an integer."""
    if rounding not in _ROUNDINGS:
        raise TypeError(f"rounding is one of {', '.join(_ROUNDINGS)}, not {rounding!r}")
    if dropped <= 0:
        return mantissa << -dropped
    half, below = 1 << (dropped - 1), (1 << dropped) - 1

    def rule(m: Any) -> Any:
        if rounding == "half_even":  # one less than a half, and one more where that makes an odd quotient even
            return (m + (half - 1) + ((m >> dropped) & 1)) >> dropped
        if rounding == "half_up":
            return (m + half) >> dropped
        if rounding == "toward_zero":
            return (m + selected(m < 0, below, 0)) >> dropped
        return m >> dropped

    return rule(mantissa) if isinstance(mantissa, int) else mantissa.monotone(rule)


@dataclass(frozen=True)
class Drop:
    """Bits that a rounding drops, and its rule."""

    bits: int
    rounding: Rounding

    @property
    def code(self) -> int:
        """A number that stands for both."""
        return len(_ROUNDINGS) * self.bits + _ROUNDINGS.index(self.rounding)

    @classmethod
    def of_code(cls, code: int) -> "Drop":
        """Return what a number stands for."""
        bits, rule = divmod(code, len(_ROUNDINGS))
        return cls(bits, _ROUNDINGS[rule])


def dropped(rule: Callable[[int], int]) -> Drop:
    """Return what a rule of rounding drops, which is read off some numbers that it rounds.

    >>> dropped(lambda mantissa: mantissa >> 1)
    Drop(bits=1, rounding='floor')
    """
    bits = _LARGE + 1 - rule(1 << _LARGE).bit_length()
    half = 1 << bits >> 1
    if rule(half) == 1:
        return Drop(bits, "half_up")
    if rule(3 * half) == 2:
        return Drop(bits, "half_even")
    return Drop(bits, "floor" if rule(-1) else "toward_zero")
