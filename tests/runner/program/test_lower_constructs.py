"""Every construct of Python that is lowered, as functions of a program: to the last bit what Python makes of it."""

import itertools
import math
import operator
from collections.abc import Callable
from typing import Any, NamedTuple

import pytest

from proofmass.runner.program.form import FLOAT, INTEGER, Value
from proofmass.runner.program.lower import lower
from tests.by_hand.evaluate_program import evaluate
from tests.by_hand.lowered import HOSTILE_INTEGERS, HOSTILE_NUMBERS, KINDS, run, same

# -- every construct ---------------------------------------------------------------------------------------------------


class Pair(NamedTuple):
    first: float
    second: int = 7


TABLE = (1.5, -2.0, 0.25)
FACTOR = 3.0


def helper(a: float, b: float = 2.0) -> float:
    return a * b + FACTOR


def chained(a: float, b: float, c: float) -> int:
    return (1 if a < b < c else 0) + (2 if a == b != c else 0) + (4 if not a >= b else 0)


def branches(a: float, b: float, c: float) -> float:
    if a > b:
        x = a
    elif b > c:
        x = -b
    else:
        return c
    y = x if x < 1.0 else b / c if c != 0.0 else 7.0
    return x + y


def shorts(a: float, b: float, c: float) -> bool:
    return (a > 0.0 and 1.0 / a > b) or (c != 0.0 and not b < c) or a == b


def values_of_shorts(a: int, b: int) -> int:
    return (a and b) + (a or 5)


def nested_loops(n: int, a: float) -> float:
    total = 0
    for i in range(n):
        if i == 5:
            continue
        for j in range(i, 0, -2):
            if j > 7:
                break
            total += a * j - i
    else_ = 0.5
    while n > 0:
        n -= 3
        if n == 2:
            break
        else_ = -else_
    return total + else_


def unpacked(a: float, n: int) -> tuple[float, int, float]:
    pair = Pair(a, n)
    (x, y), z = pair, Pair(second=n + 1, first=1.0)
    x, y = x + z.first, y - z.second
    changed = pair._replace(first=2.0)
    return x + changed.first, y, TABLE[n % 3]


def over_tables(a: float, n: int) -> float:
    total = 0.0
    for place, value in enumerate(TABLE):
        total += place * value
    for x, y in zip(TABLE, (a, 1.0, 2.0), strict=False):
        if x == 0.25:
            continue
        total -= x * y
    for value in (-2.0, 0.25, a):
        total += value
    return total + len(TABLE) + TABLE[-1] + min(a, 0.0, -a) + max(n, 2)


def dear_chain(a: float, n: int) -> bool:
    """Comparisons of what is dear, and of what only those before it make safe."""
    return over_tables(a, n) < over_tables(a, n + 1) < over_tables(a + 1.0, n + 2) < 100.0 < 200.0 / (a if n else 1.0)


def left_by_else(a: float, n: int) -> float:
    total = 0.0
    for value in (0.5, a, 2.0, a + n):
        if value < 1.0:
            total += value
        else:
            break
    for value in TABLE:
        if value > a:
            total -= value
        elif n > 1:
            continue
        total += 0.125
    return total


def lists(cells: list[float], codes: list[int], n: int) -> float:
    cells[n % 3] += 2.0
    cells[-1] = float(codes[0])
    codes[1] = codes[-1] - n
    total = 0.0
    for x in cells:
        total += x
    for i, code in enumerate(codes):
        total -= i * code
    cells[0], cells[1] = cells[1], cells[0]
    return total + cells[n - 2] + len(cells)


def from_the_end(cells: list[float], n: int) -> float:
    """Places that are counted from the end only now and then: but for their differences all numbers are natural."""
    total = 0.0
    for i in range(n):
        for j in range(2):
            total = 2.0 * total + cells[i - j] + TABLE[j - i] + (i - 2 * j) // 3
    return total


def early(a: float, n: int) -> float:
    for i in range(n):
        if i * a > 4.0:
            return i + 0.5
    while True:
        a = a * 2.0 + 2.0
        if not abs(a) < 100.0:
            return a


def numbers(a: float, n: int) -> float:
    b = abs(a) if a < 1e9 else 2.0
    whole = int(b) + round(b) + math.floor(-b) + math.ceil(b) + int(n > 2) + bool(n)
    return whole + math.sqrt(b) + math.copysign(3.0, a) + float(n) + helper(b) + helper(a, b=1.0) + (n / 7) + n**2


def integers(n: int, m: int) -> int:
    return (n // 3) + (n % 5) + (-n // 4) + (n & m | 3 ^ m) + (n >> 2) + (m << 1) + ~n + (n % -7)


def membership(n: int) -> int:
    return 1 if n in (1, 5, 9) else 2 if n not in (0, 2) else 3


def counted_by(n: int, step: int) -> int:
    total = 0
    for i in range(n, n + 20, step):
        total = 2 * total + i
    return total


def raised(a: float, b: float) -> float:
    return abs(a) ** b


def divided(a: float, b: float) -> float:
    return a // b + 4.0 * (a % b)


def after_the_last_turn(n: int) -> int:
    i, total = -1, 0
    for i in range(n):
        total += i
    return 100 * total + i


def set_within_its_turn(n: int) -> int:
    total = 0
    for i in range(n):
        i = 2 * i + 1
        total = 3 * total + i
    return total


def infinite(a: float) -> tuple[bool, bool, bool]:
    return math.isnan(a), math.isinf(a), math.isfinite(a)


def exactly(n: int, a: float) -> tuple[bool, bool, bool]:
    return n < a, n == a, a <= n


def promoted(n: int) -> float:
    x = 1
    if n > 2:
        x = 0.5
    return x * n


def extremes(a: float, b: float) -> float:
    return max((a, b)) - min((a, b, 1.0)) + operator.neg(a) + (+b)


def known_beforehand(a: float, n: int) -> float:
    known = int(2.7) + math.trunc(-2.7) + (+True)
    x = a if FACTOR > 2.0 else missing  # type: ignore[name-defined]  # noqa: F821
    if FACTOR > 5.0 and a > 0.0:
        x = x + 1.0
    if (n, n):  # noqa: F634
        x = x + 1.0
    return x * known if () or FACTOR else a


def of_integers(n: int) -> int:
    return math.floor(n) + 3 * math.ceil(n) + 5 * round(n)  # noqa: RUF057


def found_by_the_larger(n: int) -> float:
    return TABLE[max(n % 3, 1)] + TABLE[min(n % 2, 1)]


def written_late(a: float) -> float:
    x: float
    if a > 0.0:
        return a
        a = 2.0 * a
    x = 3.0 * a
    pass
    return x


def both_of(a: float) -> tuple[float, float]:
    return a, 2.0 * a


def turned(a: float, n: int) -> float:
    pair, doubled, total = Pair(a, 0), both_of, 0.0
    for i in range(n):
        pair, doubled = Pair(0.5 * pair.first, i), both_of
        for each in doubled(pair.first):
            total += each
    return total + pair.second


CASES: list[tuple[Callable[..., Any], tuple[Any, ...]]] = [
    *((f, (float, float, float)) for f in (chained, branches, shorts)),
    (values_of_shorts, (int, int)),
    *((f, (float, int)) for f in (unpacked, over_tables, left_by_else, early, numbers, dear_chain)),
    (nested_loops, (int, float)),
    (integers, (int, int)),
    *((f, (int,)) for f in (membership, after_the_last_turn, set_within_its_turn)),
    (counted_by, (int, int)),
    (infinite, (float,)),
    (exactly, (int, float)),
    (promoted, (int,)),
    (extremes, (float, float)),
    *((f, (float, float)) for f in (raised, divided)),
    *((f, (float, int)) for f in (known_beforehand, turned)),
    *((f, (int,)) for f in (of_integers, found_by_the_larger)),
    (written_late, (float,)),
]
SOME_NUMBERS = [0.0, -0.0, 1.0, -1.0, 0.25, 2.5, -3.5, 1e300, math.inf, -math.inf, math.nan]
SOME_INTEGERS = [0, 1, 2, 3, 5, 8, 11, -1, -4, -9]


@pytest.mark.parametrize(("function", "kinds"), CASES, ids=lambda case: getattr(case, "__name__", ""))
def test_constructs(function: Any, kinds: tuple[Any, ...]) -> None:
    compared = 0
    for given in itertools.product(*(SOME_NUMBERS if kind is float else SOME_INTEGERS for kind in kinds)):
        try:
            expected = function(*given)
        except (ArithmeticError, ValueError):
            continue
        wanted = function.__annotations__["return"]
        expected = wanted(expected) if wanted in KINDS else expected
        assert same(run(function, *given), expected), given
        compared += 1
    assert compared > 5


def test_a_number_divided_by_zero_is_none() -> None:
    assert math.isnan(run(divided, 1.0, 0.0))


def fails_below_zero(a: float) -> float:
    if a < 0.0:
        raise ValueError
    return math.sqrt(a)


def counts_until_it_fails(a: float) -> int:
    n = 0
    while n < 1000:
        a = fails_below_zero(a) - 0.5
        n += 1
    return n


@pytest.mark.parametrize("a", [4.0, 0.25, -1.0])
def test_what_fails_says_so_to_its_callers_and_ends_their_loops(a: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fails_below_zero, "checked", {}, raising=False)  # as of a function of an own block
    lowered = lower(counts_until_it_fails, [Value(FLOAT)])
    turns, fault = evaluate(lowered.function, a)
    expected, x = 0, a
    while x >= 0.0:
        x, expected = math.sqrt(x) - 0.5, expected + 1
    assert (turns, fault) == (expected + 1, True), "the turn that fails is the last"


@pytest.mark.parametrize("n", [0, 2])
def test_a_name_of_a_list_may_be_set_to_it_again(n: int) -> None:
    assert run(named_again, [1.0, 5.0], n) == named_again([1.0, 5.0], n)


def named_again(cells: list[float], n: int) -> float:
    some, total = cells, 0.0
    for i in range(n):
        some = cells if total >= 0.0 else cells  # noqa: RUF034
        total += some[i]
    return total + some[0]


def guarded(cells: list[float], n: int) -> float:
    return cells[n] if n < 3 else -1.0


@pytest.mark.parametrize("n", [0, 2, 3, 10**6])
def test_an_entry_that_a_condition_guards_is_not_read_without_it(n: int) -> None:
    assert run(guarded, [1.0, 2.0, 3.0], n) == guarded([1.0, 2.0, 3.0], n)


@pytest.mark.parametrize("n", [0, 1, 4])
def test_lists_are_changed_in_place(n: int) -> None:
    cells, codes = [1.0, -2.0, 0.5], [5, 6, 7, 8]
    mine = list(cells), list(codes)
    assert same(run(lists, *mine, n), lists(cells, codes, n))
    assert same((cells, codes), mine)


def test_a_difference_of_natural_numbers_is_none_itself() -> None:
    for n in range(4):
        assert run(from_the_end, [1.0, -2.0, 0.5], n) == from_the_end([1.0, -2.0, 0.5], n)


def test_large_integers_and_numbers_are_compared_exactly() -> None:
    for n, a in itertools.product(HOSTILE_INTEGERS, HOSTILE_NUMBERS):
        assert run(exactly, n, a) == exactly(n, a), (n, a)


# -- what a name and a cache depend on ---------------------------------------------------------------------------------


def test_a_function_is_lowered_once_for_each_kind_of_arguments() -> None:
    number, whole = Value(FLOAT), Value(INTEGER)
    first = lower(helper, [number])
    assert lower(helper, [Value(FLOAT)]) is first
    assert lower(helper, [whole]).function.name != first.function.name
    assert first.function.name.startswith("helper_")


def test_a_number_from_outside_that_changes_makes_another_function(monkeypatch: pytest.MonkeyPatch) -> None:
    before = lower(helper, [Value(FLOAT)])
    monkeypatch.setitem(helper.__globals__, "FACTOR", 5.0)
    after = lower(helper, [Value(FLOAT)])
    assert after.function.name != before.function.name
    assert run(helper, 1.0) == 7.0


@pytest.mark.defect(
    "S746", before="of two functions that differ in what they call, the first for both", after="each its own"
)
def test_functions_of_a_program_that_are_called_make_another_function() -> None:
    def calling(called: Any) -> Any:
        def twice(a: float) -> float:
            return called(a) + called(a)  # type: ignore[no-any-return]

        return twice

    def less(a: float) -> float:
        return a - 1.0

    first, second = (
        lower(calling(lower(of, [Value(FLOAT)]).function), [Value(FLOAT)]).function for of in (helper, less)
    )
    assert first.name != second.name
    assert evaluate(first, 4.0) == (2.0 * helper(4.0),)
    assert evaluate(second, 4.0) == (6.0,)


def test_each_statement_knows_its_line() -> None:
    made = lower(helper, [Value(FLOAT)]).function
    lines = {statement.line for statement in made.body}
    assert {(line.file, line.number) for line in lines if line} == {(__file__, helper.__code__.co_firstlineno + 1)}
