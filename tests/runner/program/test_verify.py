"""Every rule of the form of a program has its text."""

from collections.abc import Callable
from typing import Any

import pytest

from proofmass.runner.program.form import (
    FLOAT,
    INTEGER,
    TRUTH,
    Break,
    Call,
    Compute,
    External,
    For,
    Function,
    Get,
    Immediate,
    Line,
    Load,
    Program,
    Return,
    Set,
    Storage,
    Store,
    Value,
    Variable,
    View,
    While,
)
from tests.by_hand.programs import Writer, program
from tests.by_hand.verify_program import MalformedProgramError, verify

YES = Immediate(TRUTH, True)
SINE = External("sin", (FLOAT,), FLOAT)


def problems(*functions: Function) -> tuple[str, ...]:
    """What is wrong with a program."""
    with pytest.raises(MalformedProgramError) as caught:
        verify(program(*functions))
    return caught.value.problems


def written(*write: Callable[[Writer, Value, Value, Storage], Any], results: tuple[Any, ...] = ()) -> Function:
    """A function of a number x, an integer n and an array of four numbers that may be written."""
    x, n, a = Value(FLOAT, "x"), Value(INTEGER, "n"), Storage(FLOAT, 4, True, "a")
    writer = Writer("f", x, n, a, results=results)
    for one in write:
        one(writer, x, n, a)
    return writer.function


def reads_out_of_its_region(w: Writer, x: Value, n: Value, a: Storage) -> None:
    with w.when(True):
        y = w.do("add", x, 1.0, name="y")
    w.store(a, 0, y)


def reads_a_test_behind_its_loop(w: Writer, x: Value, n: Value, a: Storage) -> None:
    y = Value(TRUTH, "y")
    w.say(While([Compute(y, "less", (x, x))], y, []))
    w.do("not", y)


def jumps_in_a_test(w: Writer, x: Value, n: Value, a: Storage) -> None:
    with w.count(0, n):
        w.say(While([Break()], YES, []))


def reads_a_counter_behind_its_loop(w: Writer, x: Value, n: Value, a: Storage) -> None:
    with w.count(0, n) as i:
        pass
    w.do("add_integers", i, 1)


def defines_twice(w: Writer, x: Value, n: Value, a: Storage) -> None:
    y = w.do("add", x, 1.0, name="y")
    w.say(Compute(y, "add", (x, x)))


def views_what_cannot_be_written(w: Writer, x: Value, n: Value, a: Storage) -> None:
    fixed = Storage(FLOAT, 2, False, "fixed")
    w.say(View(fixed, a, Immediate(INTEGER, 0)))
    w.say(View(Storage(FLOAT, 1, True, "part"), fixed, Immediate(INTEGER, 0)))


def reads_beside(what: str) -> Callable[[Writer, Value, Value, Storage], Any]:
    variable = Variable(FLOAT, "v")
    number = Value(INTEGER, "y")
    if what == "unlisted":
        return lambda w, x, n, a: w.say(Get(Value(FLOAT), variable))
    return lambda w, x, n, a: w.say(Get(number, w.variable(FLOAT, "v")))


WRONG = {
    "array a has no entry 4": written(lambda w, x, n, a: w.load(a, 4)),
    "array a has no entry -1": written(lambda w, x, n, a: w.store(a, -1, x)),
    "array a has no entries 2 to 4": written(lambda w, x, n, a: w.view(a, 2, 3)),
    "array part has no length, array a has": written(lambda w, x, n, a: w.view(a, 0, None)),
    "value x is f64 where i64 is wanted": written(lambda w, x, n, a: w.load(a, x)),
    "value n is i64 where f64 is wanted": written(lambda w, x, n, a: w.do("add", x, n)),
    "value n is i64 where bool is wanted": written(lambda w, x, n, a: w.say(While([], n, []))),
    "there is no operation 'power'": written(lambda w, x, n, a: w.say(Compute(Value(FLOAT), "power", (x, x)))),
    "add takes 2 operands, not 1": written(lambda w, x, n, a: w.do("add", x)),
    "the operands of select are of different kinds": written(lambda w, x, n, a: w.do("select", True, x, n)),
    "the result of less is bool, not f64": written(lambda w, x, n, a: w.say(Compute(Value(FLOAT), "less", (x, x)))),
    "the result of select is f64, not i64": written(
        lambda w, x, n, a: w.say(Compute(Value(INTEGER), "select", (Immediate(TRUTH, True), x, x)))
    ),
    "a constant of kind f64 holds 1": written(lambda w, x, n, a: w.do("add", x, Immediate(FLOAT, 1))),
    "a constant of kind i64 holds True": written(lambda w, x, n, a: w.load(a, Immediate(INTEGER, True))),
    "64 bits do not hold the constant 9223372036854775808": written(lambda w, x, n, a: w.do("and", n, 2**63)),
    "value y is used outside of the region that defines it": written(reads_out_of_its_region),
    "value y is used outside of the region that defines it ": written(reads_a_test_behind_its_loop),
    "value i is used outside of the region that defines it": written(reads_a_counter_behind_its_loop),
    "value z is used before it is defined": written(lambda w, x, n, a: w.do("negate", Value(FLOAT, "z"))),
    "value y is defined twice": written(defines_twice),
    "array b is used before it is defined": written(lambda w, x, n, a: w.load(Storage(FLOAT, 1, False, "b"), 0)),
    "variable v is not among the variables of the function": written(reads_beside("unlisted")),
    "variable v is f64, not i64": written(reads_beside("kind")),
    "variable v is f64, not bool": written(lambda w, x, n, a: w.set(w.variable(FLOAT, "v"), True)),
    "entries of array a are f64, not i64": written(lambda w, x, n, a: w.store(a, 0, n)),
    "entries of array a are f64, not bool": written(
        lambda w, x, n, a: w.say(Load(Value(TRUTH), a, Immediate(INTEGER, 0)))
    ),
    "entries of array b are i64, those of array a f64": written(
        lambda w, x, n, a: w.say(View(Storage(INTEGER, 1, False, "b"), a, Immediate(INTEGER, 0)))
    ),
    "array part is writable, array fixed is not": written(views_what_cannot_be_written),
    "Break stands outside of a loop": written(lambda w, x, n, a: w.stop()),
    "Continue stands outside of a loop": written(lambda w, x, n, a: w.skip()),
    "Break stands outside of a loop ": written(jumps_in_a_test),
    "Return stands in the test of a loop": written(lambda w, x, n, a: w.say(While([Return()], YES, []))),
    "statements stand behind Return": written(lambda w, x, n, a: (w.leave(), w.leave())),
    "Return has 1 values; the function has 0 results": written(lambda w, x, n, a: w.leave(x)),
    "value x is f64 where bool is wanted": written(lambda w, x, n, a: w.leave(x), results=(TRUTH,)),
    "the body can end without Return, and the function has results": written(results=(FLOAT,)),
    "a loop cannot go in steps of 0": written(lambda w, x, n, a: w.say(For(Value(INTEGER), n, n, 0, []))),
    "the counter value i is f64, not i64": written(lambda w, x, n, a: w.say(For(Value(FLOAT, "i"), n, n, 1, []))),
    "sin takes 1 arguments, not 2": written(lambda w, x, n, a: w.call(SINE, x, x)),
    "sin takes a number, not the array array a": written(lambda w, x, n, a: w.call(SINE, a)),
    "sin returns f64, which is not what the call expects": written(
        lambda w, x, n, a: w.say(Call((Value(INTEGER),), SINE, (x,)))
    ),
}


@pytest.mark.parametrize("text", WRONG)
def test_a_rule_that_is_broken_is_named(text: str) -> None:
    assert f"f: {text.strip()}" in problems(WRONG[text])


def test_all_problems_come_at_once_each_with_its_line() -> None:
    x = Value(FLOAT, "x")
    line = Line("blocks/my.py", 12)
    body = [
        Compute(Value(FLOAT), "add", (x,), line),
        Store(Storage(FLOAT, 1, True, "b"), Immediate(INTEGER, 0), x, line),
    ]
    assert problems(Function("f", (x,), (), body)) == (
        "f: add takes 2 operands, not 1 (blocks/my.py:12)",
        "f: array b is used before it is defined (blocks/my.py:12)",
    )


def test_names_of_functions() -> None:
    assert problems(Function("a-b", (), ())) == ("a-b: a function's name consists of letters, digits and underscores",)
    with pytest.raises(MalformedProgramError, match="g: the function is called f"):
        verify(Program({"g": Function("f", (), ())}))
    with pytest.raises(MalformedProgramError, match="a program has no function"):
        verify(Program({}))


def test_a_variable_stands_in_the_list_once() -> None:
    v = Variable(FLOAT, "v")
    assert problems(Function("f", (), (), [], [v, v])) == ("f: variable v is defined twice",)


def test_values_belong_to_one_function() -> None:
    x = Value(FLOAT, "x")
    second = Writer("g")
    second.do("negate", x)
    assert problems(Function("f", (x,), ()), second.function) == ("g: value x belongs to f",)


def test_the_entry_has_one_result_at_most() -> None:
    w = Writer("f", results=(FLOAT, FLOAT))
    w.leave(1.0, 2.0)
    assert problems(w.function) == ("f: the entry returns 2 results; C knows one at most",)


def called(parameter: Value | Storage, argument: Any) -> tuple[str, ...]:
    """What is wrong with a call of a function of one parameter."""
    callee = Function("callee", (parameter,), ())
    fixed = Storage(FLOAT, 4, False, "fixed")
    w = Writer("f", fixed)
    w.call(callee, fixed if argument is None else argument)
    return problems(callee, w.function)


def test_arguments_suit_their_parameters() -> None:
    assert called(Storage(FLOAT, 4, True, "out"), None) == ("f: callee writes to array fixed, which is not writable",)
    assert called(Storage(FLOAT, 3, False, "in"), None) == ("f: callee takes 3 entries, not the 4 of array fixed",)
    assert called(Storage(INTEGER, 4, False, "in"), None) == ("f: callee takes an array of i64, not of f64",)
    assert called(Storage(FLOAT, 4, False, "in"), 1.0) == (
        "f: callee takes an array for array in, not the constant 1.0",
    )
    assert called(Value(FLOAT, "x"), 1) == ("f: the constant 1 is i64 where f64 is wanted",)


def test_a_function_calls_only_those_before_it() -> None:
    w = Writer("f")
    w.call(w.function)
    assert problems(w.function) == ("f: f is not among the functions before this one",)


def test_a_good_program_passes() -> None:
    x, a = Value(FLOAT, "x"), Storage(FLOAT, None, True, "a")
    inner = Writer("inner", x, results=(FLOAT,))
    with inner.when(inner.do("less", x, 0.0)) as otherwise:
        inner.leave(inner.do("negate", x))
    with inner.into(otherwise):
        inner.leave(x)
    n = Value(INTEGER, "n")
    w = Writer("f", n, a, results=(INTEGER,))
    v = w.variable(INTEGER, "v")
    part = w.view(a, n, 3)
    with w.count(0, n, 2) as i:
        w.store(part, 1, w.call(inner.function, w.load(a, i))[0])
        with w.when(w.do("equal_integers", i, 5)):
            w.stop()
        w.set(v, i)
    test: list[Any] = []
    with w.into(test):
        more = w.do("less_integers", w.get(v), 3)
    with w.loop(test, more):
        w.set(v, w.do("integer_of_truth", more))
    w.say(While([], Immediate(TRUTH, True), [Set(v, n), Return((n,))]))
    verify(program(inner.function, w.function))


def test_an_array_that_is_fixed_is_not_written() -> None:
    fixed = Storage(FLOAT, 4, False, "fixed")
    w = Writer("f", fixed)
    w.store(fixed, 0, 1.0)
    assert problems(w.function) == ("f: array fixed is not writable",)


@pytest.mark.parametrize("nested", [False, True])
def test_a_loop_that_is_left_does_not_return(nested: bool) -> None:
    def looped(leaves: bool) -> Function:
        x = Value(FLOAT, "x")
        w = Writer("f", x, results=(FLOAT,))
        with w.loop([], YES):
            small = w.do("less", x, 0.0)
            with w.when(small):
                w.leave(x)
            if leaves and nested:
                with w.when(w.do("not", small)):
                    w.stop()
            elif leaves:
                w.stop()
        return w.function

    verify(program(looped(False)))
    assert problems(looped(True)) == ("f: the body can end without Return, and the function has results",)
