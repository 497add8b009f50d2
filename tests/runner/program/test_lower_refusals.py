"""What cannot be lowered is refused, with its line, the construct and what to write instead."""

import ast
import math
import types
from typing import Any, NamedTuple

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.declaration.source import define
from proofmass.runner.program import lower as lowering
from proofmass.runner.program.form import FLOAT, INTEGER, Value
from proofmass.runner.program.lower import lower
from tests.by_hand.lowered import run

TABLE = (1.5, -2.0, 0.25)


class Pair(NamedTuple):
    first: float
    second: int = 7


def helper(a: float, b: float = 2.0) -> float:
    return a * b


def unknown(a: float) -> float:
    return a + missing  # type: ignore[name-defined]  # noqa: F821


def listed(a: float) -> float:
    return [a][0]


def texts(a: float) -> float:
    return a + "1"  # type: ignore[operator]


def wrong_field(a: float) -> float:
    return Pair(a).third  # type: ignore[attr-defined,no-any-return]


def wrong_fields(a: float) -> float:
    return Pair(a, 1, 2).first  # type: ignore[call-arg]


def wrong_entry(a: float) -> float:
    return TABLE[3]


def mixed_entries(n: int) -> Any:
    return (Pair(1.0), 2.0)[n]


def unassigned(a: float) -> float:
    if a > 0.0:
        b = 1.0
    while a < 0.0:
        a += c  # type: ignore[used-before-def]  # noqa: F821
        c = b  # noqa: F841
    return a


def not_ours(a: float) -> float:
    return math.gamma(a)


def bits_of_numbers(a: float) -> Any:
    return a & 1.0  # type: ignore[operator]


def itself(a: float) -> float:
    return itself(a - 1.0) if a > 0.0 else a


def raising(a: float) -> float:
    raise ValueError(a)


def with_else(n: int) -> int:
    for i in range(n):
        n += i
    else:
        n = 1
    return n


def other_type(a: float) -> Any:
    b: Any = a
    if a > 0.0:
        b = (1.0, 2.0)
    return b


def returns_others(a: float) -> Any:
    if a > 0.0:
        return 1.0, 2.0
    return a


def given_back(cells: list[float]) -> Any:
    return cells


def too_many(a: float) -> float:
    b, c, d = a, a  # type: ignore[misc]  # noqa: F841
    return b


def over_a_number(a: float) -> float:
    for b in a:  # type: ignore[attr-defined]
        a = b
    return a


def field_set(x: Any) -> float:
    x.first = 1.0
    return 1.0


def no_step(n: int) -> int:
    for i in range(0, n, 0):
        n += i
    return n


def starred(*values: float) -> float:
    return values[0]


def entry_set(a: float) -> float:
    (a, a)[0] = 1.0  # type: ignore[index]
    return a


def entry_changed(a: float) -> float:
    (a, a)[0] += 1.0  # type: ignore[index]
    return a


def another_list(n: int, cells: list[float], others: list[float]) -> float:
    some = cells
    if n > 0:
        some = others
    return some[0]


def unknown_part(n: int, cells: list[float]) -> float:
    return cells[n:][0]


def part_of_a_part(cells: list[float]) -> float:
    return cells[::2][0]


def one_or_the_other(n: int) -> Any:
    return (1.0, 2.0) if n > 0 else (1.0, 2.0, 3.0)


def entries_of_several_types(n: int) -> Any:
    return (Pair(1.0), (2.0,))[n]


def among_a_list(a: float, cells: list[float]) -> bool:
    return a in cells


def calling(a: float) -> float:
    total = 0.0
    for b in range(20):
        total += a / (b + 1)
    return total


def chain_of_calls(a: float) -> bool:
    return calling(a) < calling(a + 1.0) < calling(a + 2.0) < 3.0


REFUSED: list[tuple[Any, tuple[Any, ...], str]] = [
    (unknown, (1.0,), "there is no missing"),
    (listed, (1.0,), "a list"),
    (texts, (1.0,), "the str, where a number is needed"),
    (wrong_field, (1.0,), "a Pair has no third"),
    (wrong_fields, (1.0,), "Pair is given other fields than it has"),
    (wrong_entry, (1.0,), "there is no entry 3 among 3"),
    (mixed_entries, (1,), "a tuple of 2 has entries of several types"),
    (unassigned, (1.0,), "c may have no value here"),
    (not_ours, (1.0,), "gamma() is not compiled"),
    (bits_of_numbers, (1.0,), "bits of a number"),
    (itself, (1.0,), "itself calls itself"),
    (raising, (1.0,), "raise is not compiled"),
    (with_else, (1,), "else of a loop"),
    (other_type, (1.0,), "b is of another type elsewhere"),
    (returns_others, (1.0,), "it returns something else elsewhere"),
    (given_back, ([1.0],), "a list is returned"),
    (too_many, (1.0,), "3 variables of something else"),
    (over_a_number, (1.0,), "a loop over what is no list"),
    (field_set, (Pair(1.0),), "a field cannot be changed"),
    (no_step, (3,), "a range of step 0"),
    (starred, (1.0,), "* among the arguments"),
    (entry_set, (1.0,), "it cannot be changed"),
    (entry_changed, (1.0,), "it cannot be changed"),
    (another_list, (1, [1.0], [2.0]), "some is another list elsewhere"),
    (unknown_part, (1, [1.0]), "a part of a list whose ends are not known"),
    (part_of_a_part, ([1.0, 2.0],), "a part of a list"),
    (one_or_the_other, (1,), "a tuple of 2 in one case and a tuple of 3 in another"),
    (entries_of_several_types, (1,), "a tuple of 2 has entries of several types"),
    (among_a_list, (1.0, [1.0]), "in is of tuples"),
    (chain_of_calls, (1.0,), "a chain of comparisons that calls functions"),
    (helper, (1.0, 2.0, 3.0), "helper has 2 arguments, not 3"),
]


@pytest.mark.parametrize(("function", "given", "message"), REFUSED, ids=lambda case: getattr(case, "__name__", ""))
def test_what_is_refused_says_where_and_why(function: Any, given: Any, message: str) -> None:
    with pytest.raises(ModelError) as caught:
        run(function, *given)
    [problem] = caught.value.problems
    assert message in problem.message
    assert problem.file == __file__
    first = function.__code__.co_firstlineno
    assert first <= problem.line <= first + 8
    assert problem.hint


def test_an_empty_tuple_has_no_entry() -> None:
    tree = ast.parse("def empty(n):\n    return ()[n]").body[0]
    assert isinstance(tree, ast.FunctionDef)
    with pytest.raises(ModelError, match="a tuple of 0 has no entries that an index may choose"):
        lower(define(tree, __file__, {"__name__": __name__}), [Value(INTEGER)])


def test_assertions_are_refused() -> None:
    """Of a function that was made here: tools that test rewrite those of files."""
    tree = ast.parse("def asserting(a):\n    assert a").body[0]
    assert isinstance(tree, ast.FunctionDef)
    with pytest.raises(ModelError, match="assert is not compiled"):
        lower(define(tree, __file__, {"__name__": __name__}), [Value(FLOAT)])


def test_what_has_no_source_is_refused() -> None:
    made = types.FunctionType(compile("lambda a: a", "<nowhere>", "eval").co_consts[0], {})
    with pytest.raises(ModelError, match="its source cannot be read"):
        lowering.lower(made, [Value(FLOAT)])
    with pytest.raises(ModelError, match="is no function"):
        lowering.lower(print, [Value(FLOAT)])
