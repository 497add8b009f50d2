"""Integer code: the step function on Python integers, its traced code as plain Python, and compiled, are equal."""

import random
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

from proofmass.blocks.arithmetic.fixed_format import MOST_BITS
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, clip, counting_overflows, fixed, where, wrap
from proofmass.runner.fixed.integer_ir import TraceError
from proofmass.runner.fixed.step_formats import bounds, reference_step
from proofmass.runner.program.form import Compute
from proofmass.runner.program.operations import EVALUATE
from tests.by_hand.compiled import compiled as compiled_as
from tests.by_hand.integer_code import compile_step

ROUNDINGS = ("half_even", "half_up", "floor", "toward_zero")


class State(NamedTuple):
    a: Any
    b: Any


STATE = State(Fixed(20, 11), Fixed(7, 2, signed=False))


def random_step(seed: int) -> Callable[..., Any]:
    """A step of operations drawn at random, with branches; values are cast before they outgrow 64 bits."""

    def step(x: State, u: FixedValue, code: int, flag: bool, line: list[FixedValue]) -> State:
        rng = random.Random(seed)  # drawn anew in every run, in the same order on every path

        def cast(value: FixedValue) -> FixedValue:
            format = Fixed(rng.randint(4, 16), rng.randint(-2, 12), rng.random() < 0.7)
            return value.to(format, rng.choice(ROUNDINGS), rng.choice(["saturate", "wrap"]))  # type: ignore[arg-type]

        pool = [x.a, x.b, u, FixedValue(wrap(code, Fixed(9))), *line]
        branches = 0
        for _ in range(9):
            p, q = cast(rng.choice(pool)), cast(rng.choice(pool))
            kind, constant, bit = rng.randrange(10), rng.randint(-50, 50), rng.randint(0, 9)
            if kind == 0:
                r = p + q
            elif kind == 1:
                r = p - q * 3
            elif kind == 2:
                r = p * q
            elif kind == 3:
                r = where(p < q, p, q + 1)
            elif kind == 4:
                r = clip(p, FixedValue(constant, 3), q)
            elif kind == 5:
                r = FixedValue((p.mantissa & 37) ^ (q.mantissa | constant), bit)
            elif kind == 6:
                r = abs(p) + (q.mantissa >> bit)
            elif kind == 7 and branches < 2:
                branches += 1
                r = p
                if flag and p > constant:
                    r = q
                elif p.mantissa != bit or not q:
                    r = p + q
            elif kind == 8:
                r = FixedValue(p.mantissa << (q.mantissa & 7))
            else:
                r = wrap(FixedValue(-p.mantissa, q.fraction), Fixed(8, q.fraction)) * where(flag, 2, -1)
            pool.append(cast(r))
        line[1] = line[0]
        line[0] = pool[-3].to(Fixed(12, 4))
        return State(pool[-1].to(STATE.a), pool[-2].to(STATE.b, "half_up", "wrap"))

    return step


FORMATS = {"x": STATE, "u": Fixed(14, 6), "code": int, "flag": bool, "line": [Fixed(12, 4)] * 2, "return": STATE}


def some(format: Any, rng: random.Random) -> int:
    """A number of a format, its ends more often than the others."""
    low, high = bounds(format)
    return rng.choice(
        [low, high, rng.randint(low, high), rng.randint(low, high), max(low, min(high, rng.randint(-9, 9)))]
    )


@pytest.mark.parametrize("seed", range(4))
def test_random_steps_are_equal_in_every_engine(seed: int) -> None:
    function = random_step(seed)
    step = compile_step(function, FORMATS, count_overflows=True)
    reference, compiled = reference_step(function, FORMATS), compiled_as(step)
    rng = random.Random(seed + 1000)
    for i in range(150):
        x = State(some(STATE.a, rng), some(STATE.b, rng))
        arguments = (x, some(FORMATS["u"], rng), some(int, rng), bool(i % 2))
        line = [some(Fixed(12, 4), rng) for _ in range(2)]
        first, second, third = list(line), list(line), np.array(line)
        with counting_overflows() as overflows:
            expected = reference(*arguments, first)
        assert step(*arguments, second) == (expected, overflows.total)
        assert compiled(*arguments, third) == (expected, overflows.total)
        assert first == second == third.tolist()


@pytest.mark.exhaustive
def test_random_steps_without_the_count_are_equal() -> None:
    for seed in range(100, 120):
        function = random_step(seed)
        step, reference = compile_step(function, FORMATS), reference_step(function, FORMATS)
        rng = random.Random(seed)
        for i in range(20):
            x = State(some(STATE.a, rng), some(STATE.b, rng))
            arguments = (x, some(FORMATS["u"], rng), some(int, rng), bool(i % 2))
            assert step(*arguments, [3, 5]) == reference(*arguments, [3, 5])


def test_the_program_is_the_one_that_is_meant() -> None:
    def update(c: Any, x: State, u: FixedValue, line: list[FixedValue]) -> State:
        total = (x.a + c * line[1]).to(STATE.a)
        line[1] = line[0]
        line[0] = u
        return State(total, wrap(x.b + FixedValue(1, 2), STATE.b))

    formats = {"c": fixed(0.75, Fixed(4, 3)), "x": STATE, "u": Fixed(8, 8), "line": [Fixed(8, 8)] * 2, "return": STATE}
    code = compile_step(update, formats)
    assert (
        code.text(None, State(0, 0), 0, [0, 0]).partition("(")[2]
        == """x_a: i64, x_b: i64, u: i64, line: i64[2]) -> i64, i64:
    t = line[0]
    t_2 = line[1]
    t_3 = x_a + (t_2 * 6)
    t_4 = (t_3 if (-524288 < t_3) else -524288)
    line[0] := u
    line[1] := t
    return (524287 if (524287 < t_4) else t_4), ((x_b + 1) & 127)"""
    )
    numbers = {s.line.number for s in code.step(None, State(0, 0), 0, [0, 0]).body if isinstance(s, Compute) and s.line}
    first = update.__code__.co_firstlineno
    assert numbers == {first + 1, first + 4}


def test_constants_may_be_arguments_instead() -> None:
    class Constants(NamedTuple):
        gain: Any
        limited: bool

    def output(c: Constants, v0: FixedValue) -> Any:
        return (c.gain * v0).to(Fixed(8), overflow="saturate" if c.limited else "wrap")

    formats = {"c": Constants(Fixed(8, 4), True), "v0": Fixed(8), "return": Fixed(8)}
    step = compile_step(output, formats)
    assert step(Constants(32, True), 100) == 127
    assert reference_step(output, formats)(Constants(32, True), 100) == 127


def test_a_node_beyond_64_bits_is_refused_with_its_width() -> None:
    def cube(a: FixedValue) -> FixedValue:
        square = a * a
        return (square * a).to(Fixed(32, 30))

    assert compile_step(cube, {"a": Fixed(21, 20), "return": Fixed(32, 30)})(-(2**20)) == -(2**30)
    with pytest.raises(TraceError) as caught:
        compile_step(cube, {"a": Fixed(32, 30), "return": Fixed(32, 30)})
    problem = caught.value.problems[0]
    assert problem.message == "the multiply is wider than the 64 bits of compiled code"
    assert problem.got == f"[{-(2**93)}, {2**93 - 2**62}], 94 bits"
    assert problem.line == cube.__code__.co_firstlineno + 2
    assert ".to(format)" in problem.hint


def test_a_node_that_leaves_64_bits_at_its_lower_end_alone_is_refused() -> None:
    def twice(a: FixedValue) -> FixedValue:
        return (a + a).to(Fixed(8))

    def twice_less_one(a: FixedValue) -> FixedValue:
        return (a + a - 1).to(Fixed(8))  # from -2^63 - 1 to 2^63 - 3

    formats = {"a": Fixed(63), "return": Fixed(8)}
    assert compile_step(twice, formats)(-(2**62)) == -128
    with pytest.raises(TraceError) as caught:
        compile_step(twice_less_one, formats)
    assert caught.value.problems[0].got == f"[{-(2**63) - 1}, {2**63 - 3}], 65 bits"


def test_the_last_value_of_64_bits_is_computed() -> None:
    def ends(a: int, b: FixedValue) -> tuple[Any, ...]:
        return clip(a, -(2**63), 2**63 - 1), a < -(2**63) + 1, b * b, a & 2**63 - 1, a >> 200, ~a, a ^ -(2**63)

    formats = {"a": int, "b": Fixed(32), "return": (int, bool, Fixed(64), int, int, int, int)}
    step = compile_step(ends, formats)
    reference, compiled = reference_step(ends, formats), compiled_as(step)
    for a in (-(2**63), -(2**63) + 1, -1, 0, 2**63 - 1):
        for b in (-(2**31), 2**31 - 1):
            assert step(a, b) == compiled(a, b) == reference(a, b)


def test_a_branch_that_is_not_taken_cannot_overflow(monkeypatch: pytest.MonkeyPatch) -> None:
    """Straight-line code computes it, and a compiler may take a signed overflow for impossible."""

    def step(a: int, b: int) -> int:
        if -1000 < a < 1000 and b < 10:
            product = a * a * a * a
            return product + 1 if product > 5 else 1 << (a & 7)
        return clip(a, -5, 5) if b < 7 else 9

    formats = {"a": int, "b": int, "return": int}
    function = compile_step(step, formats)
    compiled = compiled_as(function)
    values = [-(2**63), -(2**62), -1001, -1000, -999, -3, 0, 1, 2, 999, 1000, 2**40, 2**63 - 1]
    for a in values:
        for b in values:
            assert function(a, b) == compiled(a, b) == step(a, b)
    assert "t = (-999 if (a < -999) else (999 if (999 < a) else a))" in function.text(0, 0)
    products = [0]

    def multiplied(a: int, b: int) -> int:
        products.append(a * b)
        return a * b

    monkeypatch.setitem(EVALUATE, "multiply_integers", multiplied)
    for a in values:
        function(a, 0)
    assert all(-(2**63) <= value < 2**63 for value in products)
    assert len(products) > 3 * len(values)


def test_a_shift_by_a_narrowed_signal_stays_within_the_word() -> None:
    def step(a: int, b: int) -> Any:
        if 0 <= b < 40:
            return wrap(a, Fixed(20)) << b
        return a >> 3

    function = compile_step(step, {"a": int, "b": int, "return": int})
    compiled = compiled_as(function)
    for a in (-(2**63), -5, 77, 2**63 - 1):
        for b in (-(2**63), -1, 0, 39, 40, 2**63 - 1):
            assert function(a, b) == compiled(a, b) == step(a, b)

    def far(a: FixedValue, b: FixedValue) -> FixedValue:
        return FixedValue(a.mantissa >> b.mantissa)

    formats = {"a": Fixed(8), "b": Fixed(8, 0, signed=False), "return": Fixed(8)}
    with pytest.raises(TraceError, match="shift by 0 to 255 places"):
        compile_step(far, formats)


@pytest.mark.parametrize(
    ("most", "said"), [(MOST_BITS, "shift by 0 to 512 places"), (MOST_BITS + 1, "by so many places")]
)
def test_a_shift_by_more_than_a_word_is_refused(most: int, said: str) -> None:
    """Where it is traced, or, of up to the bits of a format, where its code is written."""

    def far(a: FixedValue, b: FixedValue) -> FixedValue:
        return FixedValue(a.mantissa >> clip(b, 0, most).mantissa)

    with pytest.raises(TraceError, match=said):
        compile_step(far, {"a": Fixed(8), "b": Fixed(11, 0, signed=False), "return": Fixed(8)})


@pytest.mark.parametrize("divisor", [0, -1, -4, 3, 6, 2.0, 0.5])
def test_only_a_whole_power_of_two_divides(divisor: float) -> None:
    formats = {"a": Fixed(8), "return": Fixed(16)}
    for divided in (lambda a: FixedValue(a.mantissa // divisor), lambda a: FixedValue(a.mantissa % divisor)):
        with pytest.raises(TraceError, match=f"a divisor of {divisor!r}"):
            compile_step(divided, formats)


def test_a_step_without_results_writes_its_buffers() -> None:
    def update(line: list[FixedValue], u: FixedValue) -> None:
        for k in range(len(line) - 1, 0, -1):
            line[k] = line[k - 1]
        line[0] = u

    step = compile_step(update, {"line": [Fixed(8)] * 3, "u": Fixed(8)})
    line = np.array([1, 2, 3])
    assert compiled_as(step)(line, 7) is None
    assert line.tolist() == [7, 1, 2]


def test_the_reference_refuses_what_does_not_fit() -> None:
    def step(a: FixedValue) -> tuple[FixedValue, Any, Any]:
        return a * 4, a > 1, a.mantissa

    reference = reference_step(step, {"a": Fixed(8), "return": (Fixed(9), bool, int)})
    assert reference(63) == (252, True, 63)
    with pytest.raises(OverflowError, match=r"256 does not fit Fixed\(9, 0\)"):
        reference(64)
