"""The table of integer operations: its texts say what it computes, and its facts hold."""

import itertools
from typing import Any, get_args

import pytest

from proofmass.runner.fixed.operations import COMPARISONS, OPERATIONS, OperationKind, OperationName

NUMBERS = (-7, -1, 0, 1, 2, 6)
every_operation = pytest.mark.parametrize("operation", OPERATIONS.values(), ids=OPERATIONS)


def values(operation: OperationKind) -> list[tuple[int, ...]]:
    """Operands to try; a number of places is not negative."""
    count = max(number + 1 for number in range(3) if f"{{{number}}}" in operation.python)
    tried = itertools.product(NUMBERS, repeat=count)
    return [operands for operands in tried if operation.word != "shifted" or operands[1] >= 0]


def test_every_name_is_in_the_table_or_is_a_source() -> None:
    assert set(get_args(OperationName)) == {"constant", "input", *OPERATIONS}
    assert {"less", "less_equal", "equal", "not_equal"} == COMPARISONS


@every_operation
def test_texts_in_python_and_amaranth_compute_the_value(operation: OperationKind) -> None:
    def mux(condition: Any, chosen: int, otherwise: int) -> int:
        return chosen if condition else otherwise

    for operands in values(operation):
        texts = [f"({operand})" for operand in operands]
        expected = operation.evaluate(*operands)
        assert type(expected) is int
        assert int(eval(operation.python.format(*texts))) == expected
        assert int(eval(operation.in_amaranth(*texts), {"Mux": mux})) == expected


@every_operation
def test_facts_hold_for_all_operands(operation: OperationKind) -> None:
    for operands in values(operation):
        value = operation.evaluate(*operands)
        if operation.comparison:
            assert value in (0, 1)
        if operation.commutative:
            assert operation.evaluate(*reversed(operands)) == value
        if operation.neutral is not None and operands[1] == operation.neutral:
            assert value == operands[0]
        if operation.of_equals is not None and operands[0] == operands[1]:
            assert value == (operands[0] if operation.of_equals == "operand" else operation.of_equals)
        assert operation.interval(*((operand, operand) for operand in operands)) == (value, value)


@every_operation
def test_intervals_are_those_of_all_values_inside(operation: OperationKind) -> None:
    least = 0 if operation.word == "shifted" else -3
    count = len(values(operation)[0])
    ends = [(low, high) for low in range(-3, 3) for high in range(low, 3)]
    for intervals in itertools.product(ends, repeat=count):
        if count > 1 and intervals[1][0] < least:
            continue
        inside = itertools.product(*(range(low, high + 1) for low, high in intervals))
        found = {operation.evaluate(*operands) for operands in inside}
        assert operation.interval(*intervals) == (min(found), max(found))
