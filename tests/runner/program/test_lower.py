"""Functions of Python as functions of a program: every block's, every construct, to the last bit."""

import inspect
import itertools
import math
import operator
import random
import struct
from collections.abc import Callable
from typing import Any, NamedTuple

import pytest

from proofmass.blocks.arithmetic.fixed_point import counting_overflows
from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import shape_of
from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.language import arithmetic
from proofmass.runner.fixed.digital import digital_block
from proofmass.runner.fixed.step_formats import SteadyValue, bounds, filled, held_as
from proofmass.runner.plan.constants import constants_of, typed
from proofmass.runner.program.form import FLOAT, INTEGER, Value
from proofmass.runner.program.lower import lower
from tests.by_hand.evaluate_program import evaluate
from tests.by_hand.integer_code import Code
from tests.by_hand.lowered import KINDS, run

HOSTILE_NUMBERS = [
    *(0.0, -0.0, 1.0, -1.0, 0.5, -0.5, 2.5, -2.5, 3.0, 1e308, -1e308, 5e-324, -5e-324, 1e-300, math.inf, -math.inf),
    *(math.nan, 2.0**63, -(2.0**63), 2.0**52 + 0.5, 2.0**53),
]
HOSTILE_INTEGERS = [
    *(0, 1, -1, 2, -2, 3, 7, 63, 64, -63, 2**31, 2**53, 2**53 + 1, -(2**53) - 1, 2**62),
    *(2**63 - 1, -(2**63), -(2**63) + 1),
]


def same(one: Any, other: Any) -> bool:
    """Whether values are of one type and one pattern of bits; one NaN is as another."""
    if isinstance(one, tuple | list):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, float):
        nan = math.isnan(one) and math.isnan(other)
        return isinstance(other, float) and (nan or struct.pack("d", one) == struct.pack("d", other))
    return type(one) is type(other) and bool(one == other)


# -- every function of every block ------------------------------------------------------------------------------------


def number(kind: Any, dice: random.Random) -> Any:
    """A number, one in four of them hostile."""
    if kind is float:
        return dice.choice(HOSTILE_NUMBERS) if dice.random() < 0.25 else dice.uniform(-3.0, 3.0)
    return dice.random() < 0.5 if kind is bool else dice.randrange(0, 9)


def drawn(block: Block, behaviour: Behaviour, name: str, port: Any, dice: random.Random) -> Any:
    """A value for an argument of a block's function."""
    kind = type(block)
    if name in ("time", "normal", "tick"):
        return number(int if name == "tick" else float, dice)
    if name == "x":
        state: Any = kind.state_class()
        return state(*(number(held_as(of), dice) for of in state.__annotations__.values()))
    declared = port if name == "out" else kind.buffers.get(name) or kind.inputs[name]
    shape = shape_of(block, declared)
    of = held_as(declared.dtype)
    entry = int if of is bool and shape else of
    return [number(entry, dice) for _ in range(shape[0])] if shape else number(entry, dice)


def behaviours(kind: type[Block]) -> Any:
    """The functions that a loop calls, each with the port that it computes."""
    for name, behaviour in kind.output_functions.items():
        yield behaviour, kind.outputs[name]
    for name in ("update", "derivative"):
        if name in kind.functions:
            yield kind.functions[name], None
    for behaviour in (*kind.corners.values(), *(each for pair in kind.events.values() for each in pair)):
        yield behaviour, None


@pytest.mark.exhaustive("VibrationEllipse")
@pytest.mark.parametrize("kind", [k for k in all_blocks().values() if not k.has_formats()], ids=lambda k: k.__name__)
def test_every_function_of_every_block(kind: Any) -> None:
    block = kind()
    if any(buffer.recorded for buffer in kind.buffers.values()):
        pytest.skip("has no recording by default")
    dice = random.Random(kind.__name__)
    constants = constants_of(block, block, 1e-3)
    for behaviour, port in behaviours(kind):
        compared = 0
        for _ in range(25):
            given = [drawn(block, behaviour, name, port, dice) for name in behaviour.arguments]
            mine = [list(value) if isinstance(value, list) else value for value in given]
            try:
                expected = behaviour.function(constants, *given)
            except (ArithmeticError, ValueError, IndexError):
                continue
            expected = declared(expected, behaviour, port)
            assert same(run(behaviour.function, constants, *mine), expected), (behaviour.function, given, constants)
            assert all(same(a, b) for a, b in zip(given, mine, strict=True)), (behaviour.function, given, mine)
            compared += 1
        assert compared


def declared(value: Any, behaviour: Behaviour, port: Any) -> Any:
    """What Python gives, each number of the type that the block declares."""
    if isinstance(value, tuple):
        return typed(value)
    wanted = held_as(behaviour.returns)
    return wanted(value) if value is not None and wanted in KINDS and type(value) is not wanted else value


@pytest.mark.parametrize("kind", [k for k in all_blocks().values() if k.has_formats()], ids=lambda k: k.__name__)
def test_integer_code_of_every_digital_block(kind: Any) -> None:
    try:
        made = digital_block("block", kind(), 1e-3)
    except ModelError:
        pytest.skip("is wider than 64 bits by default")
    dice = random.Random(kind.__name__)
    for step in made.steps.values():
        code = Code(step.code)
        for _ in range(8):
            formats = [(step.traced.formats[name], name) for name in step.traced.arguments[1:]]
            given = [filled(*pair, lambda _, of: within(of, dice)) for pair in formats]
            given = [None if isinstance(value, SteadyValue) else value for value in given]
            mine = [list(value) if isinstance(value, list) else value for value in given]
            with counting_overflows(refusals=True) as overflows:
                expected = step.reference(made.constants, *given)
            beside = [int(overflows.lost != 0)] * step.overflows + [int(overflows.refused != 0)] * step.refuses
            found = code(made.constants, *mine)
            result, *others = found if beside else (found,)
            assert same(result, expected), (step.name, given)
            assert [int(other != 0) for other in others] == beside
            assert given == mine


def within(format: Any, dice: random.Random) -> Any:
    """A number of a format, one in four of them an end."""
    low, high = bounds(format)
    value = dice.choice((low, high)) if dice.random() < 0.25 else dice.randint(max(low, -(2**40)), min(high, 2**40))
    return bool(value) if format is bool else value


NOT_LOWERED = {*arithmetic.OF_C, *arithmetic.OF_MACHINES, "place"}


@pytest.mark.exhaustive("1500-true_divide")
@pytest.mark.parametrize(
    "function",
    [f for n, f in inspect.getmembers(arithmetic, inspect.isfunction) if n not in NOT_LOWERED],
    ids=lambda function: function.__name__,
)
@pytest.mark.parametrize("most", [1_500, pytest.param(None, marks=pytest.mark.exhaustive)])
def test_operations_on_hostile_values(most: int | None, function: Any) -> None:
    of = {float: HOSTILE_NUMBERS, int: HOSTILE_INTEGERS}
    kinds = [kind for name, kind in function.__annotations__.items() if name != "return"]
    operands = list(itertools.product(*(of[kind] for kind in kinds)))
    if most is not None and len(operands) > most:
        operands = random.Random(function.__name__).sample(operands, most)
    for given in operands:
        if function is arithmetic.power and abs(given[1]) > 64:
            continue
        try:
            expected = function(*given)
        except (ArithmeticError, ValueError):
            continue
        if not isinstance(expected, int) or -(2**63) <= expected < 2**63:
            assert same(run(function, *given), expected), given


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
    (membership, (int,)),
    (counted_by, (int, int)),
    (infinite, (float,)),
    (exactly, (int, float)),
    (promoted, (int,)),
    (extremes, (float, float)),
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


def test_an_overflow_is_an_operation_of_programs() -> None:
    for a, b in itertools.product(HOSTILE_INTEGERS, repeat=2):
        assert run(overflows, a, b) == tuple(not -(2**63) <= c < 2**63 for c in (a + b, a - b, a * b))
    with pytest.raises(ModelError, match="in is of tuples"):  # 64 bits do not hold what it looks at
        run(arithmetic.add_fails, 1, 2)


def overflows(a: int, b: int) -> tuple[bool, bool, bool]:
    return arithmetic.add_fails(a, b), arithmetic.subtract_fails(a, b), arithmetic.multiply_fails(a, b)


def turned_bits(n: int) -> int:
    return n ^ 0x8000_0000_0000_0001


def too_many_bits(n: int) -> int:
    return n ^ 0x1_0000_0000_0000_0000


def test_integers_of_64_bits_are_those_of_a_machine() -> None:
    for n in HOSTILE_INTEGERS:
        assert run(turned_bits, n) % 2**64 == (n % 2**64) ^ (2**63 + 1)
    with pytest.raises(OverflowError, match="more than 64 bits"):  # refused before, where files are checked
        run(too_many_bits, 1)


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


@pytest.mark.parametrize("n", [0, 1, 4])
def test_lists_are_changed_in_place(n: int) -> None:
    cells, codes = [1.0, -2.0, 0.5], [5, 6, 7, 8]
    mine = list(cells), list(codes)
    assert same(run(lists, *mine, n), lists(cells, codes, n))
    assert same((cells, codes), mine)


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


def test_each_statement_knows_its_line() -> None:
    made = lower(helper, [Value(FLOAT)]).function
    lines = {statement.line for statement in made.body}
    assert {(line.file, line.number) for line in lines if line} == {(__file__, helper.__code__.co_firstlineno + 1)}
