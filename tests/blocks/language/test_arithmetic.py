"""Value and fault of every operation that can fail, as programs take them, against Python's own at hostile operands.

Compiled code is made of these functions, and plain Python calls its own: each pair of operands is seen here at once.
"""

import ast
import itertools
import math
import operator
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from proofmass.blocks.language import arithmetic, operations
from proofmass.blocks.language.arithmetic import HIGHEST, LOWEST
from proofmass.blocks.language.operations import Checked
from tests.blocks.language.test_operations import HOSTILE_INTEGERS, HOSTILE_NUMBERS, bits

SMALL = [*range(-6, 8), 62, 63, 64, 65, 1000]
OF_INTEGERS: dict[type[ast.operator], Callable[..., Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.LShift: operator.lshift, ast.RShift: operator.rshift,
    ast.Pow: operator.pow,
}  # fmt: skip
OF_NUMBERS: dict[type[ast.operator], Callable[..., Any]] = {
    ast.Div: operator.truediv, ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod
}  # fmt: skip
TO_INTEGER: dict[Any, Callable[..., Any]] = {f: f for f in (int, math.trunc, round, math.floor, math.ceil)}
CHECKED: list[tuple[Checked, Callable[..., Any], str]] = [
    *((checked, OF_INTEGERS[name], "ii") for name, checked in operations.OF_INTEGERS.items()),
    *((checked, OF_NUMBERS[name], "nn") for name, checked in operations.OF_NUMBERS.items()),
    *((checked, TO_INTEGER[name], "n") for name, checked in operations.TO_INTEGER.items()),
    *(
        (checked, function, "".join("i" if kind is int else "n" for kind in kinds))
        for function, (checked, kinds, _) in operations.FUNCTIONS.items()
        if isinstance(checked, Checked)
    ),
    (operations.NEGATE, operator.neg, "i"),
    (operations.ABSOLUTE, abs, "i"),
    (operations.POWER, operator.pow, "nn"),
]
OPERANDS = {"i": HOSTILE_INTEGERS, "n": HOSTILE_NUMBERS}


def in_python(function: Callable[..., Any], operands: Sequence[Any]) -> bytes:
    """The bits of the value; nothing where there is none that a program has."""
    a, b = (*operands, 0)[:2]
    if function in (operator.lshift, operator.pow, operator.rshift) and isinstance(b, int):
        least = {operator.pow: 2, operator.lshift: 1, operator.rshift: math.inf}[function]
        if b < 0 or (abs(a) >= least and b > 64):
            return b""  # the type of a negative power would follow from a value; the others would take hours
    if function is math.factorial and a > 20:
        return b""
    try:
        value = function(*operands)
    except (ArithmeticError, ValueError):
        return b""
    fits = not isinstance(value, complex) and (isinstance(value, float) or LOWEST <= value <= HIGHEST)
    return bits(value) if fits else b""


def in_a_program(checked: Checked, operands: Sequence[Any]) -> bytes:
    value = checked.value(*operands)
    return b"" if checked.fails(*((value,) if checked.by_value else ()), *operands) else bits(value)


OWN = [row for row in CHECKED if row[0].value is not row[1]]  # others are Python's own functions


@pytest.mark.parametrize(("checked", "function", "kinds"), OWN, ids=lambda item: getattr(item, "__name__", ""))
def test_every_operation_has_value_and_fault_of_python(
    checked: Checked, function: Callable[..., Any], kinds: str
) -> None:
    columns = [[*OPERANDS[kind], *(SMALL if kind == "i" else ())] for kind in kinds]
    found = [(operands, in_python(function, operands)) for operands in itertools.product(*columns)]
    assert [in_a_program(checked, operands) for operands, _ in found] == [expected for _, expected in found]
    assert any(expected for _, expected in found)


def test_an_integer_and_a_number_are_compared_exactly() -> None:
    for a, b in itertools.product(HOSTILE_INTEGERS, HOSTILE_NUMBERS):
        assert arithmetic.compare(a, b) == (2 if math.isnan(b) else (a > b) - (a < b)), (a, b)


def test_numbers_are_close_as_python_has_it() -> None:
    tolerances = (0.0, -0.0, 1e-300, 1e-9, 0.5, 1.0, 3.0, math.inf, -1.0)
    for a, b, relative, absolute in itertools.product(HOSTILE_NUMBERS[::2], HOSTILE_NUMBERS, tolerances, tolerances):
        fails = arithmetic.is_close_fails(a, b, relative, absolute)
        assert fails == (min(relative, absolute) < 0.0)
        if not fails:
            expected = math.isclose(a, b, rel_tol=relative, abs_tol=absolute)
            assert arithmetic.is_close(a, b, relative, absolute) == expected, (a, b, relative, absolute)


@pytest.mark.parametrize("length", range(5))
def test_a_place_counts_from_the_end_if_it_is_negative(length: int) -> None:
    for index in range(-7, 8):
        exists = index in range(-length, length)
        assert arithmetic.place_fails(index, length) != exists
        assert not exists or arithmetic.place(index, length) == range(length)[index]
        assert arithmetic.place(index, length) in range(max(length, 1)), "it is read even so"


def test_a_range_has_at_most_as_many_turns_as_a_tick_allows() -> None:
    most = arithmetic.MOST_TURNS
    for start, step in itertools.product((0, -5, 7), (1, 2, -3)):
        for turns in (0, 1, most - 1, most, most + 1):
            fails = arithmetic.range_end_fails(start, start + turns * step, step)
            assert fails == (turns > most)
            assert arithmetic.range_end(start, start + turns * step, step) == start + (0 if fails else turns * step)
    assert not arithmetic.range_end_fails(0, 2 * most, 0), "the step alone is wrong"
    assert [(arithmetic.stride(step), arithmetic.stride_fails(step)) for step in (-2, 0, 1)] == [
        (-2, False), (1, True), (1, False)
    ]  # fmt: skip


@pytest.mark.parametrize(("kind", "folded"), [(sum, operator.add), (math.prod, operator.mul)])
def test_a_total_fails_where_it_exceeds_64_bits_even_for_a_while(kind: Any, folded: Callable[..., Any]) -> None:
    checked = operations.TOTALS[kind]
    for entries in itertools.product((*HOSTILE_INTEGERS[1::2], 0, -1), repeat=3):
        on_the_way = list(itertools.accumulate(entries, folded))
        assert checked.fails(entries) == any(not LOWEST <= value <= HIGHEST for value in on_the_way), entries
        assert checked.value(entries) == on_the_way[-1]


def test_the_first_of_the_extremes_is_taken() -> None:
    for kind in (min, max):
        checked = operations.EXTREMES[kind]
        for entries in itertools.product((2**53, 2**53 + 1, -0.0, 0.0, -1.5), repeat=3):
            assert bits(float(checked.value(entries))) == bits(float(kind(entries)))
            assert type(checked.value(entries)) is type(kind(entries))
        assert checked.fails(())
        assert not checked.fails((0,))
