"""What follows from what in a function, by its text: against small functions read by hand."""

from typing import NamedTuple

import pytest

from proofmass.runner.derivatives.passed_on import RESULT, passed_on


class Pair(NamedTuple):
    level: float
    count: int


def chosen(c: float, a: float, b: float) -> float:
    return a if b > c else 0.0


def counted(c: float, x: Pair, a: float) -> Pair:
    if x.count >= 3:
        return x
    far = abs(a - x.level) > c
    return Pair(a, x.count + 1 if far else 0)


def replaced(c: float, x: Pair, a: float) -> Pair:
    return x._replace(level=c * x.level + a)


def swapped(c: float, x: Pair, a: float) -> Pair:
    level, count = x.level + a, x.count
    return Pair(count=count, level=level)


def kept(c: float, line: list[float], a: float) -> float:
    other = line
    last = line[0]
    for i in range(3):
        other[i] = a
    return last


def summed(c: float, line: list[float], a: float) -> float:
    total = 0.0
    for value in line:
        total += value
    return total


def turned(c: float, a: float, b: float) -> float:
    for _ in range(4):
        a, b = b, a
    return a


def hidden(c: float, a: float) -> float:
    def inner() -> float:
        return a

    return inner()


def gathered(c: float, a: float) -> float:
    values = [c, c]
    values[0] = a
    return values[0]


def _put(to: list[float], value: float) -> None:
    to[0] = value


def written(c: float, line: list[float], a: float) -> float:
    _put(to=line, value=a)
    return line[0]


def called(c: float, a: float, b: float) -> float:
    return max(a, -b) * c


FIELDS = Pair._fields


@pytest.mark.parametrize(
    ("function", "fields", "lists", "expected"),
    [
        (chosen, (), (), {RESULT: {"a"}}),
        (called, (), (), {RESULT: {"a", "b", "c"}}),
        (turned, (), (), {RESULT: {"a", "b"}}),
        (counted, FIELDS, (), {"level": {"a", "x.level"}, "count": {"x.count"}}),
        (replaced, FIELDS, (), {"level": {"a", "c", "x.level"}, "count": {"x.count"}}),
        (swapped, FIELDS, (), {"level": {"a", "x.level", "x.count"}, "count": {"a", "x.level", "x.count"}}),
        (kept, (), ("line",), {RESULT: {"line", "a"}, "line": {"a"}}),
        (written, (), ("line",), {RESULT: {"line", "a"}, "line": {"line", "a"}}),
        (summed, (), ("line",), {RESULT: {"line"}, "line": set()}),
    ],
)
def test_what_follows(function: object, fields: tuple[str, ...], lists: tuple[str, ...], expected: object) -> None:
    assert passed_on(function, fields, lists) == expected  # type: ignore[arg-type]


def test_what_has_functions_or_lists_inside_or_no_text_is_not_known() -> None:
    assert passed_on(hidden, (), ()) is None
    assert passed_on(gathered, (), ()) is None
    assert passed_on(abs, (), ()) is None
