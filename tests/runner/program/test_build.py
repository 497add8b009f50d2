"""Functions written statement by statement: their ends, what is folded, and what is never reached."""

import math
from typing import Any

import pytest

from proofmass.runner.program.build import Builder
from proofmass.runner.program.form import FLOAT, INTEGER, TRUTH, Immediate, Return
from proofmass.runner.program.lower import program
from proofmass.runner.program.operations import EVALUATE
from tests.by_hand.evaluate_program import evaluate
from tests.by_hand.verify_program import verify


def test_a_function_whose_end_can_be_reached_returns_zeros_there() -> None:
    builder = Builder("positive")
    x = builder.parameter(FLOAT, "x")
    with builder.when(builder.compute("less", 0.0, x)):
        builder.give(x, 1, True)
    function = builder.function()
    assert evaluate(function, 2.5) == (2.5, 1, True)
    assert evaluate(function, -2.5) == (0.0, 0, False)


def test_nothing_is_written_after_a_return() -> None:
    builder = Builder("at_once")
    x = builder.parameter(FLOAT, "x")
    builder.give(x)
    builder.compute("negate", x)
    function = builder.function()
    assert [type(statement) for statement in function.body] == [Return]


@pytest.mark.parametrize("nested", [False, True])
def test_a_loop_without_a_condition_ends_where_it_is_left(nested: bool) -> None:
    """Only one that is never left ends its function: behind the others zeros are returned."""
    builder = Builder("counted")
    last = builder.parameter(INTEGER, "last")
    count = builder.variable(INTEGER, "count", 0)
    with builder.repeated(lambda: True):
        builder.set(count, builder.compute("add_integers", builder.get(count), 1))
        with builder.when(builder.compute("less_integers", 5, builder.get(count))):
            builder.give(builder.get(count))
        if nested:
            with builder.when(builder.compute("less_integers", last, builder.get(count))):
                builder.leave()
        else:
            builder.leave()
    function = builder.function()
    verify(program(function))
    assert evaluate(function, 2) == (0,)
    assert evaluate(function, 9) == ((6,) if nested else (0,))


def test_a_loop_that_is_never_left_ends_its_function() -> None:
    builder = Builder("searched")
    count = builder.variable(INTEGER, "count", 0)
    with builder.repeated(lambda: True):
        builder.set(count, builder.compute("add_integers", builder.get(count), 1))
        with builder.when(builder.compute("less_integers", 5, builder.get(count))):
            builder.give(builder.get(count))
    function = builder.function()
    verify(program(function))
    assert evaluate(function) == (6,)
    assert not isinstance(function.body[-1], Return)


@pytest.mark.parametrize(
    ("operation", "constant", "first", "result"),
    [
        ("both", True, True, None),
        ("both", False, True, False),
        ("both", False, False, False),
        ("either", False, True, None),
        ("either", True, False, True),
        ("add_integers", 0, True, None),
        ("or", 0, False, None),
        ("multiply_integers", 1, False, None),
        ("multiply_integers", 0, True, 0),
        ("multiply_integers", 0, False, 0),
        ("subtract_integers", 0, False, None),
        ("shift_left", 0, False, None),
        ("shift_right", 0, False, None),
    ],
)
def test_what_a_constant_decides_is_not_computed(operation: str, constant: Any, first: bool, result: Any) -> None:
    """The result is the other operand (None here) or the constant, as it is for every value of the other."""
    kind = TRUTH if isinstance(constant, bool) else INTEGER
    builder = Builder("decided")
    other = builder.parameter(kind, "other")
    folded = builder.compute(operation, *((constant, other) if first else (other, constant)))
    assert folded == (other if result is None else Immediate(kind, result))
    assert builder.function().body == []
    for value in (True, False) if kind is TRUTH else (-3, 0, 7):
        wanted = value if result is None else result
        assert EVALUATE[operation](*((constant, value) if first else (value, constant))) == wanted


@pytest.mark.parametrize(("operation", "value"), [("subtract_integers", -4), ("shift_left", 0), ("shift_right", 0)])
def test_zero_in_the_first_place_decides_nothing(operation: str, value: int) -> None:
    builder = Builder("undecided")
    other = builder.parameter(INTEGER, "other")
    builder.give(builder.compute(operation, 0, other))
    assert evaluate(builder.function(), 4) == (value,)


@pytest.mark.parametrize("a", [1.0, -1.0, 0.0, -0.0, math.nan])
@pytest.mark.parametrize("b", [0.0, -0.0])
def test_a_division_by_zero_is_that_of_ieee_754(a: float, b: float) -> None:
    result = EVALUATE["divide"](a, b)
    if a == 0.0 or math.isnan(a):
        assert math.isnan(result)
    else:
        assert result == math.inf * a * math.copysign(1.0, b)
