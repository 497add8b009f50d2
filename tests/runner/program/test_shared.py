"""Which large functions a program has once."""

import pytest

from proofmass.runner.program.form import FLOAT, Function, Program, Storage, Value
from proofmass.runner.program.shared import shared
from proofmass.runner.targets import machine_code
from proofmass.runner.targets.llvm_text import llvm_text
from tests.by_hand.programs import Writer, program


def chain(name: str, length: int) -> Function:
    """So many sums, one behind the other: x + 1 + 2 + ..."""
    x = Value(FLOAT, "x")
    w = Writer(name, x, results=(FLOAT,))
    total = x
    for number in range(length):
        total = w.do("add", total, float(number))
    w.leave(total)
    w.function.inline = True
    return w.function


def caller(called: Function, times: int, in_branches: bool) -> Program:
    """A program that calls a function so many times, always or where its argument is positive."""
    x, out = Value(FLOAT, "x"), Storage(FLOAT, times, True, "out")
    w = Writer("entry", x, out)
    for place in range(times):
        if in_branches:
            with w.when(w.do("less", 0.0, x)):
                w.store(out, place, w.call(called, x)[0])
        else:
            w.store(out, place, w.call(called, x)[0])
    return program(called, w.function)


@pytest.mark.parametrize(
    ("length", "times", "in_branches", "once"),
    [
        (300, 1, True, True),
        (300, 2, False, False),
        (300, 6, False, True),
        (100, 1, True, False),
        (100, 30, False, False),
    ],
)
def test_large_functions_are_shared(length: int, times: int, in_branches: bool, once: bool) -> None:
    called = chain("large", length)
    made = caller(called, times, in_branches)
    assert (called in shared(made)) is once
    attribute = "noinline" if once else "alwaysinline"
    head = next(line for line in llvm_text(made).splitlines() if line.startswith("define") and "@f.0(" in line)
    number = head.split("#")[1].split()[0]
    assert f"attributes #{number} = {{ {attribute}" in llvm_text(made)


def test_a_function_without_its_shared_part_is_small() -> None:
    """A part that runs in branches alone is shared; what calls it is copied then, however often."""
    part = chain("part", 300)
    x, out = Value(FLOAT, "x"), Value(FLOAT, "x")
    w = Writer("whole", x, results=(FLOAT,))
    with w.when(w.do("less", x, 0.5)):
        w.leave(w.call(part, x)[0])
    w.leave(x)
    w.function.inline = True
    entry = Writer("entry", out, results=(FLOAT,))
    total = out
    for _ in range(10):
        total = entry.call(w.function, total)[0]
    entry.leave(total)
    made = program(part, w.function, entry.function)
    assert shared(made) == {part}
    expected = 0.25
    for _ in range(10):
        expected = expected + sum(range(300)) if expected < 0.5 else expected
    assert machine_code.load(made)(0.25) == expected
