"""Functions of Python as functions of a program: every block's, every construct, to the last bit."""

import ctypes
import inspect
import itertools
import random
from typing import Any

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
from proofmass.runner.program.operations import wrapped
from tests.by_hand.integer_code import Code
from tests.by_hand.lowered import HOSTILE_INTEGERS, HOSTILE_NUMBERS, KINDS, run, same

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


@pytest.mark.exhaustive(but=80)
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


# -- operations that may not fit ------------------------------------------------------------------------------------


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


LEAST, TOO_LITTLE = -(2**63), -(2**63) - 1


def above_the_least(n: int) -> int:
    return n - LEAST


def above_too_little(n: int) -> int:
    return n - TOO_LITTLE


def test_integers_of_64_bits_are_those_of_a_machine() -> None:
    for n in HOSTILE_INTEGERS:
        assert run(turned_bits, n) % 2**64 == (n % 2**64) ^ (2**63 + 1)
    with pytest.raises(OverflowError, match="more than 64 bits"):  # refused before, where files are checked
        run(too_many_bits, 1)
    assert run(above_the_least, -1) == 2**63 - 1
    with pytest.raises(OverflowError, match="more than 64 bits"):
        run(above_too_little, -2)


def test_integers_wrap_as_those_of_c() -> None:
    for value in (2**63, -(2**63) - 1, 2**64, 2**64 + 5, -(2**64), 3 * 2**63, 2**126 - 1, -(2**126), *HOSTILE_INTEGERS):
        assert wrapped(value) == ctypes.c_int64(value).value
