"""Numbers that are homogeneous in one factor s: what is computed with them shows its degree, the power of s in it.

    x = part * s^degree   for every s of the factor's ball

Sums of different degrees, and functions of a number of any degree but 0, have none: they are known as balls alone. Zero
has every degree.
"""

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import flint

from proofmass.runner.derivatives.ball import (
    LAST_PLACES,
    Ball,
    UndecidedError,
    arb_of,
    ball_exponential,
    is_number,
    is_zero,
)


class Homogeneous(Ball):
    """A ball times a power of a positive factor, whose degree is None where it follows the factor in another way.

    >>> x = Homogeneous(flint.arb(3), 1, flint.arb(1).union(2))
    >>> degree_of(x * (2.0 * x) + x * x), degree_of(x * x + x), degree_of(x / x)
    (2, None, 0)
    """

    __slots__ = ("degree", "factor", "part")

    def __init__(self, part: Any, degree: int | None, factor: Any) -> None:
        if not part.is_finite():
            raise UndecidedError("a number without bounds")
        self.part, self.degree, self.factor = part, degree, factor

    @property
    def arb(self) -> Any:
        """All that it may be, as one of Arb's."""
        return self.part * self.factor**self.degree if self.degree else self.part

    def __repr__(self) -> str:
        return f"Homogeneous({Ball(self.part)!r}, {self.degree})"

    def followed_by(self, function: Ball) -> Ball:
        """Return a function of this number as what it is: a ball without a degree."""
        return self.of(function.arb, None)

    def widened(self) -> Ball:
        """Return the number with the last places of each value as a further radius."""
        return self.of(self.part * flint.arb(1, LAST_PLACES), self.degree)

    def __add__(self, other: Any) -> Any:
        if not is_number(other):
            return NotImplemented
        if is_zero(other) or is_zero(self):
            return self if is_zero(other) else other
        if self.degree is not None and self.degree == degree_of(other):
            return self.of(self.part + _part(other), self.degree)
        return self.of(self.arb + arb_of(other), None)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        return self + -other

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __neg__(self) -> Ball:
        return self.of(-self.part, self.degree)

    def __abs__(self) -> Ball:
        return self.of(abs(self.part), self.degree)

    def __mul__(self, other: Any) -> Any:
        if not is_number(other):
            return NotImplemented
        if isinstance(other, int | float) and other == 0.0:
            return 0.0
        degree = degree_of(other)
        if self.degree is None or degree is None:
            return self.of(self.arb * arb_of(other), None)
        return self.of(self.part * _part(other), self.degree + degree)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        if not is_number(other):
            return NotImplemented
        return self * (other**-1 if isinstance(other, Homogeneous) else Ball(1 / arb_of(other)))

    def __rtruediv__(self, other: Any) -> Any:
        return self**-1 * other

    def __pow__(self, exponent: int) -> Any:
        if not isinstance(exponent, int):
            raise TypeError("a power of a ball needs an integer exponent")
        return self.of(self.part**exponent, None if self.degree is None else self.degree * exponent)

    def of(self, part: Any, degree: int | None) -> Ball:
        """Return a number of the same factor."""
        return Ball(part) if degree == 0 else Homogeneous(part, degree, self.factor)


def degree_of(number: Any) -> int | None:
    """Return the degree of a number, 0 for all that do not follow the factor; None without one."""
    return number.degree if isinstance(number, Homogeneous) else 0


def _part(number: Any) -> Any:
    return number.part if isinstance(number, Homogeneous) else arb_of(number)


def loop_degree(rows: Sequence[Sequence[Any]], order: int) -> Fraction | None:
    """Return the degree of the gain of a loop [A B; C D] of so many states, None where it may have none.

    With s^e for some e as units of states and values of the wire, the loop has the same numbers for
    every s, but for s^gain at its wire. So its poles are those of a loop with that factor at the wire.
    """
    known = _degrees(rows, order)
    return None if known is None else known[1]


def homogeneous_exponential(rows: Sequence[Sequence[Any]], period: float) -> list[list[Any]]:
    """Return `ball_exponential` of rows of which some numbers are homogeneous: with units s^e they are balls."""
    square = [*rows, *[[0.0] * len(rows[0])] * (len(rows[0]) - len(rows))]
    known = _degrees(square, len(square))
    some = next(value for row in rows for value in row if isinstance(value, Homogeneous))
    if known is None:
        return [[some.followed_by(value) for value in row] for row in ball_exponential(rows, period)]
    degrees, _ = known
    parts = ball_exponential([[Ball(_part(value)) for value in row] for row in rows], period)
    return [[some.of(value.arb, degrees[i] - degrees[j]) for j, value in enumerate(row)] for i, row in enumerate(parts)]


def _degrees(rows: Sequence[Sequence[Any]], order: int) -> tuple[list[int], Fraction | None] | None:
    """Return the degree of each state and value, and that of the loop, with which all rows are homogeneous.

    A row has the degree of its entry more than the column has, the loop's less if it is an output. A
    way that comes round asks for a degree of the loop. None where these differ.
    """
    beside: list[list[tuple[int, int, int]]] = [[] for _ in rows]
    for i, row in enumerate(rows):
        for j, value in enumerate(row):
            if is_zero(value):
                continue
            if (degree := degree_of(value)) is None:
                return None
            beside[j].append((i, degree, int(i >= order)))
            beside[i].append((j, -degree, -int(i >= order)))
    known: dict[int, tuple[int, int]] = {}  # of each node, its degree but for so many times the loop's
    asked = set[Fraction]()
    for first in range(len(rows)):
        waiting = [] if first in known else [first]
        known.setdefault(first, (0, 0))
        while waiting:
            here = waiting.pop()
            for node, degree, times in beside[here]:
                there = known[here][0] + degree, known[here][1] + times
                if node not in known:
                    known[node] = there
                    waiting.append(node)
                off, turns = (a - b for a, b in zip(there, known[node], strict=True))
                if turns:
                    asked.add(Fraction(off, turns))
                elif off:
                    return None
    if len(asked) > 1:
        return None
    return [known[node][0] for node in range(len(rows))], next(iter(asked), None)
