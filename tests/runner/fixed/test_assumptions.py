"""Intervals under assumptions: against every input that meets them."""

import itertools
import operator
import random
from collections.abc import Callable, Iterator

import pytest

from proofmass.runner.fixed.assumptions import REACH, Assumptions
from proofmass.runner.fixed.integer_ir import IntegerProgram, Operation

Values = dict[Operation, int]
EVALUATED: dict[str, Callable[..., int]] = {
    **{"add": operator.add, "subtract": operator.sub, "multiply": operator.mul, "negate": operator.neg},
    **{"shift_left": operator.lshift, "shift_right": operator.rshift, "narrow": operator.pos, "pipe": operator.pos},
    **{"and": operator.and_, "or": operator.or_, "xor": operator.xor, "minimum": min, "maximum": max},
    **{"less": operator.lt, "less_equal": operator.le, "equal": operator.eq, "not_equal": operator.ne},
    "select": lambda a, b, c: b if a else c,
}
INPUTS = (("a", -6, 9), ("b", -3, 12))


def every_run(program: IntegerProgram) -> Iterator[Values]:
    """Yield the values of all operations, for all inputs."""
    for pair in itertools.product(*(range(o.low, o.high + 1) for o in program.operations if o.kind == "input")):
        given, values = iter(pair), Values()
        for operation in program.operations:
            if operation.kind == "constant":
                values[operation] = operation.low
            elif operation.kind == "input":
                values[operation] = next(given)
            else:
                values[operation] = int(EVALUATED[operation.kind](*(values[o] for o in operation.operands)))
        if all(o.low <= values[o] <= o.high for o in program.operations):  # a "narrow" is a promise of its caller
            yield values


def hull(runs: list[Values], operation: Operation) -> tuple[int, int]:
    values = [run[operation] for run in runs]
    return min(values), max(values)


def program_of() -> tuple[IntegerProgram, Operation, Operation]:
    program = IntegerProgram()
    a, b = (program.input(*row) for row in INPUTS)
    return program, a, b


SHAPES: dict[str, Callable[[IntegerProgram, Operation], Operation]] = {  # of one operand: all follow exactly
    "itself": lambda _, a: a,
    "narrow": lambda p, a: p.narrow(a, -5, 7),
    "pipe": lambda p, a: p.make("pipe", a),
    "negate": lambda p, a: p.make("negate", a),
    "add": lambda p, a: p.make("add", a, p.constant(5)),
    "add first": lambda p, a: p.make("add", p.constant(5), p.make("negate", a)),
    "subtract": lambda p, a: p.make("subtract", a, p.constant(3)),
    "subtract from": lambda p, a: p.make("subtract", p.constant(3), a),
    "shift left": lambda p, a: p.make("shift_left", a, p.constant(2)),
    "shift right": lambda p, a: p.make("shift_right", a, p.constant(1)),
    "rounded": lambda p, a: p.make("shift_right", p.make("add", a, p.constant(2)), p.constant(2)),
    "chain": lambda p, a: p.make("subtract", p.make("shift_left", p.make("negate", a), p.constant(1)), p.constant(7)),
}


@pytest.mark.exhaustive(but=16)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("kind", ["less", "less_equal", "equal", "not_equal"])
def test_one_comparison_is_followed_exactly(shape: str, kind: str) -> None:
    """Of a function of one input beside any number, each interval is the hull of the runs that are left.

    That it is another number says something at an end of the interval alone.
    """
    for limit, turned, outcome in itertools.product(range(-30, 31), (False, True), (False, True)):
        program = IntegerProgram()
        end = SHAPES[shape](program, program.input(*INPUTS[0]))
        sides = (program.constant(limit), end) if turned else (end, program.constant(limit))
        condition = program.make(kind, *sides)  # type: ignore[arg-type]
        runs = [values for values in every_run(program) if bool(values[condition]) == outcome]
        if condition.kind == "constant" or not runs:
            continue
        known = Assumptions()
        known.assume(condition, outcome)
        other = outcome == (kind == "not_equal") and kind in ("equal", "not_equal")
        for operation in program.operations if not other else [condition]:
            assert known.interval(operation) == hull(runs, operation), (limit, operation)
        if other:
            low, high = known.interval(end)
            assert (low > end.low, high < end.high) == (end.low == limit, end.high == limit)
            assert low <= hull(runs, end)[0] <= hull(runs, end)[1] <= high


@pytest.mark.parametrize("kind", ["less", "less_equal", "equal"])
@pytest.mark.parametrize("outcome", [False, True])
def test_two_inputs_limit_each_other(kind: str, outcome: bool) -> None:
    program, a, b = program_of()
    for first, second in ((a, b), (b, a)):
        condition = program.make(kind, first, second)  # type: ignore[arg-type]
        runs = [values for values in every_run(program) if bool(values[condition]) == outcome]
        known = Assumptions()
        known.assume(condition, outcome)
        for operation in (a, b):
            assert known.interval(operation) == hull(runs, operation)
        assert known.interval(condition) == (outcome, outcome)


@pytest.mark.parametrize(("below", "interval"), [(21, (9, 20)), (10, (9, 9)), (9, (-9, 8))])
def test_a_sum_is_no_less_than_its_operands_say(below: int, interval: tuple[int, int]) -> None:
    """a is 9 and b at least 0, so that a + b is at least 9; that it is less than 9 too comes never to pass."""
    program, a, b = program_of()
    total = program.make("add", a, b)
    known = Assumptions()
    known.assume(program.make("less", total, program.constant(below)), True)
    known.assume(program.make("equal", a, program.constant(9)), True)
    known.assume(program.make("less", b, program.constant(0)), False)
    assert known.interval(total) == interval


def test_both_sides_of_a_conjunction_hold() -> None:
    """1 < a and b < 4; of "or" that is false, neither; what is not known of either stays."""
    for kind, outcome, expected in (
        ("and", True, ((2, 9), (-3, 3))),
        ("or", False, ((-6, 1), (4, 12))),
        ("and", False, ((-6, 9), (-3, 12))),
        ("or", True, ((-6, 9), (-3, 12))),
    ):
        program, a, b = program_of()
        above, below = program.make("less", program.constant(1), a), program.make("less", b, program.constant(4))
        known = Assumptions()
        known.assume(program.make(kind, above, below), outcome)  # type: ignore[arg-type]
        assert (known.interval(a), known.interval(b)) == expected


def test_bits_of_numbers_are_no_conjunction() -> None:
    """That a & b is not 0 says nothing of a alone, also where one of them is a truth."""
    program, a, b = program_of()
    for first in (a, program.make("less", b, program.constant(4))):
        known = Assumptions()
        known.assume(program.make("and", first, b), True)
        assert known.interval(b) == (-3, 12)
        assert known.interval(first) == (first.low, first.high)
    unsigned = program.input("bits", 0, 3)
    truth = program.make("less", b, program.constant(4))
    known.clear()
    known.assume(program.make("and", truth, unsigned), True)
    assert known.interval(unsigned) == (0, 3)


def test_a_number_as_a_condition() -> None:
    """A number that is not 0 may be anything else; one that is 0 is 0, and so is what it is a copy of."""
    program, a, b = program_of()
    total = program.make("subtract", a, program.constant(4))
    known = Assumptions()
    known.assume(total, True)
    assert known.interval(a) == (-6, 9)
    known.assume(total, False)
    assert known.interval(a) == (4, 4)
    for low, high in ((0, 14), (-3, 1)):  # one end as of a truth
        number = program.input(f"to {high}", low, high)
        known.clear()
        known.assume(number, True)
        assert known.interval(number) == (low, high)
    positive = program.narrow(program.make("less", a, b), 0, 1)
    known.clear()
    known.assume(program.narrow(program.make("add", b, program.constant(3)), 0, 14), False)
    assert known.interval(b) == (-3, -3)
    known.assume(positive, True)
    assert known.interval(a) == (-6, -4)


def test_the_end_of_a_with_takes_its_assumption_back() -> None:
    program, a, b = program_of()
    first, second = program.make("less", a, program.constant(5)), program.make("less", b, a)
    double = program.make("shift_left", a, program.constant(1))
    known = Assumptions()
    known.assume(first, True)
    before = known.interval(a), known.interval(b), known.interval(double)
    with known.also(second, True):
        assert known.interval(a) == (-2, 4)
        assert known.interval(b) == (-3, 3)
        assert known.interval(double) == (-4, 8)
    assert (known.interval(a), known.interval(b), known.interval(double)) == before == ((-6, 4), (-3, 12), (-12, 8))
    with pytest.raises(KeyError), known.also(second, True):
        raise KeyError
    assert known.interval(a) == (-6, 4)
    known.clear()
    assert (known.interval(a), known.interval(double)) == ((-6, 9), (-12, 18))


def test_a_contradiction_changes_nothing() -> None:
    """A path that is never taken: both a < 0 and 3 < a."""
    program, a, _ = program_of()
    known = Assumptions()
    known.assume(program.make("less", a, program.constant(0)), True)
    known.assume(program.make("less", program.constant(3), a), True)
    assert known.interval(a) == (-6, -1)


@pytest.mark.parametrize("down", [False, True])
def test_how_far_an_assumption_is_followed(down: bool) -> None:
    """Through `REACH` operations, up or down a chain."""
    for steps in (REACH, REACH + 1):
        program, a, b = program_of()
        chain = [a]
        for number in range(steps):
            chain.append(
                program.make("add", chain[-1], program.constant(1)) if number % 2 else program.make("pipe", chain[-1])
            )
        begin, last = (chain[-1], a) if down else (a, chain[-1])
        known = Assumptions()
        known.assume(program.make("less", program.constant(begin.low + 5), begin), True)
        assert known.interval(last) == (last.low + 6 * (steps == REACH), last.high)
        assert known.interval(b) == (b.low, b.high)


def random_program(number: int) -> tuple[IntegerProgram, list[Operation], random.Random]:
    """Operations of every kind on two inputs and small numbers, and conditions among them."""
    dice = random.Random(number)
    program, a, b = program_of()
    made = [a, b, *(program.constant(dice.randint(-4, 7)) for _ in range(3))]
    shifts = [program.constant(n) for n in (0, 1, 2)]
    conditions = list[Operation]()
    for _ in range(14):
        kind = dice.choice([k for k in EVALUATED if k != "narrow"])
        operands = [dice.choice(made[-8:] if dice.random() < 0.7 else made) for _ in range(3)]
        if kind.startswith("shift"):
            operands[1] = dice.choice(shifts)
        if kind == "select" and conditions:
            operands[0] = dice.choice(conditions)
        count = 3 if kind == "select" else 1 if kind in ("negate", "pipe") else 2
        made.append(program.make(kind, *operands[:count]))  # type: ignore[arg-type]
        if (made[-1].low, made[-1].high) == (0, 1):
            conditions.append(made[-1])
    return program, conditions, dice


@pytest.mark.parametrize("number", range(40))
def test_no_value_is_ever_outside(number: int) -> None:
    """Any conditions, one after the other, of random programs: each run that meets them lies within."""
    program, conditions, dice = random_program(number)
    runs, known = list(every_run(program)), Assumptions()
    for condition in dice.sample(conditions, min(4, len(conditions))):
        outcome = dice.random() < 0.5
        left = [values for values in runs if bool(values[condition]) == outcome]
        if not left:
            break
        runs = left
        known.assume(condition, outcome)
        for operation in program.operations:
            low, high = known.interval(operation)
            exact = hull(runs, operation)
            assert operation.low <= low <= exact[0]
            assert exact[1] <= high <= operation.high
