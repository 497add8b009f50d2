"""The trace of a step function: exact intervals, branches, sharing, and what is refused with which words."""

import inspect
import itertools
from collections.abc import Callable
from typing import Any, NamedTuple

import pytest

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, clip, fixed, stored, where, wrap
from proofmass.runner.fixed.integer_ir import IntegerProgram, TraceError
from proofmass.runner.fixed.operations import interval_of
from proofmass.runner.fixed.trace import Traced, trace
from tests.by_hand.integer_code import compile_step

INTERVALS = [(-5, 6), (0, 7), (-8, -3), (2, 2), (-1, 0), (3, 9)]
OPERATIONS: dict[str, Callable[..., int]] = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "and": lambda a, b: a & b,
    "or": lambda a, b: a | b,
    "xor": lambda a, b: a ^ b,
    "less": lambda a, b: int(a < b),
    "less_equal": lambda a, b: int(a <= b),
    "equal": lambda a, b: int(a == b),
    "not_equal": lambda a, b: int(a != b),
    "minimum": min,
    "maximum": max,
}
WORD = Fixed(6)


def span(low: int, high: int) -> range:
    return range(low, high + 1)


def traced(function: Callable[..., Any], **formats: Any) -> Traced:
    return trace(function, formats)


def result_interval(function: Callable[..., Any], **formats: Any) -> tuple[int, int]:
    """The interval of a function's one result."""
    node = traced(function, **formats, **{"return": Fixed(64)}).results["return"]
    return node.low, node.high


def refused(function: Callable[..., Any], line_has: str, *, result: Any = None, **formats: Any) -> str:
    """The message of the refusal, which must name the line of the function that holds the text."""
    with pytest.raises(TraceError) as caught:
        compile_step(function, {**formats, "return": result or WORD})
    lines, first = inspect.getsourcelines(function)
    expected = [first + i for i, line in enumerate(lines) if line_has in line]
    problem = caught.value.problems[0]
    assert (problem.file, problem.line) == ("test_trace.py", expected[0])
    assert problem.hint
    assert problem.key.startswith(function.__name__)
    return str(caught.value)


@pytest.mark.parametrize("operation", OPERATIONS)
def test_intervals_are_those_of_brute_force(operation: str) -> None:
    for a, b in itertools.product(INTERVALS, INTERVALS):
        results = [OPERATIONS[operation](x, y) for x in span(*a) for y in span(*b)]
        assert interval_of(operation, [a, b]) == (min(results), max(results)), (a, b)


@pytest.mark.parametrize("operation", ["and", "or", "xor"])
def test_bitwise_intervals_of_all_small_ranges(operation: str) -> None:
    ranges = [(low, high) for low in range(-4, 4) for high in range(low, 4)]
    for a, b in itertools.product(ranges, ranges):
        results = [OPERATIONS[operation](x, y) for x in span(*a) for y in span(*b)]
        assert interval_of(operation, [a, b]) == (min(results), max(results)), (a, b)


def test_shifts_by_a_range_of_places() -> None:
    for a, places in itertools.product(INTERVALS, [(0, 3), (2, 2)]):
        for operation in ("shift_left", "shift_right"):
            shift = int.__lshift__ if operation == "shift_left" else int.__rshift__
            results = [shift(x, k) for x in span(*a) for k in span(*places)]
            assert interval_of(operation, [a, places]) == (min(results), max(results))


def test_intervals_of_whole_steps_are_those_of_brute_force() -> None:
    small, byte = Fixed(4, 2), Fixed(8, 5)

    def rounded(a: FixedValue) -> Any:
        return a.to(Fixed(10, 2), "half_even").mantissa

    def to_zero(a: FixedValue) -> Any:
        return (a + 3).to(Fixed(10, 1), "toward_zero").mantissa

    def saturated(a: FixedValue) -> Any:
        return (a * 3 + 1).to(Fixed(6, 4), "half_up").mantissa

    def wrapped(a: FixedValue) -> Any:
        return (a + 1).to(Fixed(4, 2), overflow="wrap").mantissa

    def square(a: FixedValue) -> Any:
        return (a * a).mantissa

    def magnitude(a: FixedValue) -> Any:
        return abs(a).mantissa

    def clipped(a: FixedValue) -> Any:
        return clip(a, -1, 1).mantissa

    for function in (rounded, to_zero, saturated, wrapped, square, magnitude, clipped):
        for format in (small, byte):
            results = [function(FixedValue(m, format.fraction)) for m in span(format.lowest, format.highest)]
            found = result_interval(function, a=format)
            assert found == (min(results), max(results)), (function, format)


def test_a_plain_if_merges_its_outcomes_and_keeps_their_ranges() -> None:
    def limited(a: Any) -> Any:
        if a > 10:
            a = fixed(10, Fixed(8))
        elif a < -10:
            a = fixed(-10, Fixed(8))
        return a

    found = traced(limited, a=Fixed(8), **{"return": Fixed(5)})
    assert (found.results["return"].low, found.results["return"].high, found.paths) == (-10, 10, 3)
    step = compile_step(limited, {"a": Fixed(8), "return": Fixed(5)})
    assert [step(m) for m in span(-128, 127)] == [min(max(m, -10), 10) for m in span(-128, 127)]


@pytest.mark.parametrize("by", [-1, 1])
def test_a_register_holds_its_range_alone(by: int) -> None:
    def moved(a: Any) -> Any:
        return a + by

    assert "the value does not fit its register" in refused(moved, "return a + by", a=Fixed(4), result=Fixed(4))


def test_a_number_decides_as_in_python() -> None:
    def decided(a: Any) -> Any:
        return a if a.mantissa & 6 else fixed(-1, Fixed(4))

    step = compile_step(decided, {"a": Fixed(4), "return": Fixed(4)})
    assert [step(m) for m in span(-8, 7)] == [m if m & 6 else -1 for m in span(-8, 7)]


def test_conditions_narrow_what_they_were_made_of() -> None:
    def of_sum(a: Any) -> Any:
        return a.mantissa if a + 3 > 10 else 20

    def of_aligned(a: Any) -> Any:
        return a.mantissa if a > FixedValue(5, 3) else 20

    def of_both(a: Any) -> Any:
        return where((a > 3) & (a <= 9), a.mantissa, 5)

    def of_equal(a: Any) -> Any:
        return a.mantissa if a == 4 else 5

    def not_zero(a: Any) -> Any:
        return a.mantissa if a > -1 and a != 0 else 9

    def shifted(a: Any) -> Any:
        return a.mantissa if a.mantissa >> 2 >= 3 else 31

    def shifted_below(a: Any) -> Any:
        return a.mantissa if a.mantissa >> 2 <= 3 else -40

    def of_negative(a: Any) -> Any:
        return a.mantissa if -a > 5 else -40

    def of_difference(a: Any) -> Any:
        return a.mantissa if 7 - a > 3 else -40

    def of_either(a: Any) -> Any:
        return -40 if (a < -6) | (a - 1 > 6) else a.mantissa

    expected = {of_sum: (8, 31), of_aligned: (1, 31), of_both: (4, 9), of_equal: (4, 5), not_zero: (1, 31)}
    expected |= {shifted: (12, 31), shifted_below: (-40, 15), of_negative: (-40, -6), of_difference: (-40, 3)}
    for function, interval in {**expected, of_either: (-40, 7)}.items():
        assert result_interval(function, a=WORD) == interval, function
        results = [function(FixedValue(m, WORD.fraction)) for m in span(-32, 31)]
        assert (min(results), max(results)) == interval


def test_conditions_of_python_all_work() -> None:
    def chain(a: Any, b: Any) -> Any:
        if -3 <= a < 3 and not (b == 2 and a != 0):
            return min(a, b) + max(a, b, 1)
        if (a and b) or a * b > 5:
            return abs(a - b)
        return a if bool(b) else -b

    formats = {"a": Fixed(4, 1), "b": Fixed(4, 1), "return": Fixed(8, 2)}
    step = compile_step(chain, formats)
    for a, b in itertools.product(span(-8, 7), span(-8, 7)):
        assert step(a, b) == stored(chain(FixedValue(a, 1), FixedValue(b, 1)), Fixed(8, 2))


@pytest.mark.exhaustive
def test_a_loop_that_the_range_ends_is_unrolled() -> None:
    def bits(a: Any) -> Any:
        count = 0
        while a > 0:
            count += 1
            a = FixedValue(a.mantissa >> 1)
        return count

    step = compile_step(bits, {"a": Fixed(16), "return": Fixed(8)})
    for m in span(-3, 9999):
        assert step(m) == max(m, 0).bit_length()


def test_the_same_value_is_one_node() -> None:
    def step(a: Any, b: Any) -> Any:
        first = (a + b) * (a - b)
        second = (b + a) * (a - b)
        return first + second, first - second, where(first == second, a, b)

    found = traced(step, a=WORD, b=WORD, **{"return": (Fixed(20), Fixed(20), WORD)})
    operations = [operation.kind for operation in found.program.live(found.results.values())]
    assert operations.count("multiply") == 1
    assert found.results["return[1]"].constant == 0
    assert found.results["return[2]"].name == "a"


def test_known_values_are_folded() -> None:
    program = IntegerProgram()
    a = program.input("a", -8, 7)
    zero, one, eight = map(program.constant, (0, 1, 8))
    assert program.make("add", a, zero) is a
    assert program.make("multiply", one, a) is a
    assert program.make("multiply", a, zero) is zero
    assert program.make("multiply", a, eight).kind == "shift_left"
    assert program.make("less", a, eight) is one
    assert program.make("subtract", a, a) is zero
    assert program.make("minimum", a, eight) is a
    assert program.make("select", program.make("less", a, zero), one, zero).kind == "less"
    count = program.input("count", 0, 3)
    assert program.make("select", count, one, zero).kind == "select", "of 2 it is 1"
    assert program.narrow(a, 3, 3) is program.constant(3)
    small = program.narrow(program.narrow(a, 0, 7), 2, 9)
    assert (small.operands, small.low, small.high, small.width) == ((a,), 2, 7, 4)
    assert program.make("and", small, program.constant(7)) is small


def test_every_node_names_its_line() -> None:
    def step(a: Any, b: Any) -> Any:
        total = a + b
        return (total * b).to(Fixed(12))

    first = step.__code__.co_firstlineno
    found = traced(step, a=WORD, b=WORD, **{"return": Fixed(12)})
    places = {operation.kind: operation.place for operation in found.program.operations}
    assert str(places["add"]) == f"test_trace.py:{first + 1}"
    assert str(places["multiply"]) == f"test_trace.py:{first + 2}"


class Registers(NamedTuple):
    total: Any
    chips: Any


def test_a_value_that_does_not_fit_its_register_is_refused() -> None:
    def grows(x: Registers, a: FixedValue) -> Registers:
        total = x.total + a
        return Registers(total, x.chips)

    registers = Registers(Fixed(8, 4), Fixed(10, 0, signed=False))
    message = refused(grows, "total = ", x=registers, a=Fixed(8, 4), result=registers)
    assert "grows: return.total: the value does not fit its register" in message
    assert "[-256, 254]" in message
    assert "[-128, 127] of Fixed(8, 4), which holds -8 to 7.9375" in message
    assert "add .to(format), or clip(value, low, high)" in message


def test_a_refused_overflow_is_decided_by_the_range() -> None:
    def cast(a: FixedValue, b: FixedValue) -> FixedValue:
        if a < 0:
            return b.to(Fixed(6), overflow="refuse")
        return (a + b).to(Fixed(7), overflow="refuse") if b < 0 else (a + b).to(Fixed(6), overflow="refuse")

    message = refused(cast, "if b < 0", a=WORD, b=WORD)
    assert "[0, 62]" in message
    assert "[-32, 31] of Fixed(6, 0)" in message


def test_what_has_no_place_in_integer_code_is_refused() -> None:
    table = [1, 2, 3]

    def loop(a: Any) -> Any:
        total = 0
        for _ in range(a.mantissa):
            total += 1
        return total

    def index(a: Any) -> Any:
        return table[a.mantissa]

    def quotient(a: Any) -> Any:
        return a / 3

    def whole_quotient(a: Any) -> Any:
        return a.mantissa // 3

    def integer_quotient(a: Any) -> Any:
        return a.mantissa / 3

    def power(a: Any) -> Any:
        return a.mantissa**2

    def float_constant(a: Any) -> Any:
        return a + 0.5

    def raw_float(a: Any) -> Any:
        return a.mantissa * 0.5

    def to_float(a: Any) -> Any:
        return float(a.mantissa)

    def far(a: Any) -> Any:
        return 1 << a.mantissa

    def raises(a: Any) -> Any:
        if a > 30:
            raise ValueError("too large: stay below")
        return a

    def asserts(a: Any) -> Any:
        assert a > 3
        return a

    cases = [
        (asserts, "assert a", "an assertion that could fail", "integers and fixed-point values"),
        (loop, "range(", "a signal bounds a loop or indexes a list", "constant length"),
        (index, "return table", "a signal bounds a loop or indexes a list", "where()"),
        (quotient, "a / 3", "a quotient has no exact fixed-point value", "constant reciprocal"),
        (whole_quotient, "// 3", "a division", "constant power of two"),
        (integer_quotient, "mantissa / 3", "a quotient of integers", "reciprocal"),
        (power, "**2", "a power", "multiply"),
        (float_constant, "+ 0.5", "a float has no fixed-point format", "write fixed(value, format, rounding)"),
        (raw_float, "* 0.5", "a float among integers", "write fixed(value, format, rounding)"),
        (to_float, "return float", "a signal in floating point", "FixedValue"),
        (far, "1 <<", "a shift by so many places", "clip()"),
        (raises, "raise Value", "too large", "stay below"),
    ]
    for function, line_has, fault, remedy in cases:
        message = refused(function, line_has, a=WORD)
        assert fault in message
        assert remedy in message.partition("hint:")[2]


def test_too_many_paths_are_refused_with_the_remedy() -> None:
    def bits(a: Any) -> Any:
        total = 0
        for k in range(9):
            if (a.mantissa >> k) & 1:
                total = total + (k * k)
        return total

    message = refused(bits, "if (a", a=Fixed(16), result=Fixed(16))
    assert "more than 256 paths through the branches" in message
    assert "write where(condition, a, b)" in message

    def with_where(a: Any) -> Any:
        total = 0
        for k in range(9):
            total = total + where((a.mantissa >> k) & 1, k * k, 0)
        return total

    step = compile_step(with_where, {"a": Fixed(16), "return": Fixed(16)})
    assert all(step(m) == bits(FixedValue(m)) for m in span(0, 511))


def test_a_loop_that_a_signal_would_end_is_refused() -> None:
    def endless(a: Any) -> Any:
        while wrap(a, WORD) != 3:
            a = wrap(a + 1, WORD)
        return a

    assert "constant length" in refused(endless, "while", a=WORD)


def test_steps_without_end_are_refused() -> None:
    def long(a: Any) -> Any:
        for k in range(60_000):
            a = wrap(a + k, WORD)
        return a

    assert "20000 operations" in refused(long, "a + k", a=WORD)


def test_every_argument_has_a_format() -> None:
    with pytest.raises(ValueError, match="a format for every argument and no other: b"):
        trace(lambda a, b: a, {"a": WORD, "return": WORD})


def test_results_of_another_form_are_refused() -> None:
    def pair(a: Any) -> Any:
        return a, a

    assert "fraction bits" in refused(lambda_fine, "def", a=Fixed(8, 6), result=Fixed(8, 4))
    assert "3 values are expected" in refused(pair, "def", a=WORD, result=(WORD, WORD, WORD))


def lambda_fine(a: Any) -> Any:
    return a
