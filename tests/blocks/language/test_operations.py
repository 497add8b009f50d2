"""Every operation of a user's function means in compiled code, to the last bit, what it means in Python."""

import inspect
import math
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proofmass.blocks.language import arithmetic
from proofmass.blocks.language.arithmetic import HIGHEST, LOWEST
from proofmass.blocks.language.functions import plain_form
from proofmass.blocks.language.operations import TURN
from tests.blocks.language import one_operation_each
from tests.by_hand.compiled import over_columns

Number = Any
Outcome = tuple[bytes, bool]  # the bits of the value, and whether there is none

HOSTILE_INTEGERS = [
    *(0, 1, -1, 2, -2, 3, 7, 10, 63, 64, -64, 1000, 2**31, -(2**32), 3037000499, 3037000500, -3037000500),
    *(2**53 - 1, 2**53, 2**53 + 1, -(2**53) - 1, 2**62, -(2**62), HIGHEST, HIGHEST - 1, LOWEST, LOWEST + 1),
]
HOSTILE_NUMBERS = [
    *(0.0, -0.0, 1.0, -1.0, 0.5, -0.5, 1.5, 2.5, -2.5, 2.0, 3.0, 10.0, 1e-320, -5e-324, 2.2250738585072014e-308),
    *(1e308, -1e308, math.inf, -math.inf, math.nan, 2.0**52 + 0.5, 2.0**53, 2.0**63, -(2.0**63), 1e19, 710.0, -745.2),
    *(math.pi, 0.1, 1.0 + 2.0**-52, 1.0 - 2.0**-53, 4503599627370495.5, -4503599627370495.5, 9007199254740993.0),
    *(2914806573710131.5, 0.6560024633502852),  # the quotient less a remainder lies between two whole numbers
]
integers = st.one_of(st.sampled_from(HOSTILE_INTEGERS), st.integers(LOWEST, HIGHEST), st.integers(-100, 100))
numbers = st.one_of(st.sampled_from(HOSTILE_NUMBERS), st.floats(), st.floats(-10.0, 10.0))
OF_TYPES: dict[tuple[type, type], list[Callable[..., Number]]] = {}
for function in vars(one_operation_each).values():
    if inspect.isfunction(function):
        OF_TYPES.setdefault(tuple(inspect.get_annotations(function).values()), []).append(function)  # type: ignore[arg-type]
OPERANDS = {int: integers, float: numbers}
TYPES = pytest.mark.parametrize("types", OF_TYPES, ids=lambda types: " and ".join(kind.__name__ for kind in types))


def python(function: Callable[..., Number], a: Number, b: Number) -> Outcome:
    """What Python gives; nothing, where it raises, or gives what is no number of 64 bits."""
    if function.__name__ == "to_the_power" and b < 0:
        return b"", True  # the type of the result would follow from a value: such a power is of numbers
    least = {"to_the_power": 2, "shifted_left": 1}.get(function.__name__, 0)
    if least and abs(a) >= least and b > 64:
        return b"", True  # Python would try, for hours
    if function.__name__ == "factorial_of" and a > 20:
        return b"", True  # so here
    try:
        value = function(a, b)
    except (ArithmeticError, ValueError, IndexError):
        return b"", True
    if isinstance(value, complex) or (isinstance(value, int) and not LOWEST <= value <= HIGHEST):
        return b"", True
    return bits(value), False


def bits(value: Number) -> bytes:
    """A value with its sign, and one NaN for all."""
    if isinstance(value, float):
        return b"nan" if math.isnan(value) else struct.pack("d", value)
    return struct.pack("q", int(value))


class Compiled:
    """All functions of two types, or every `apart`-th, as one compiled loop over many operands."""

    def __init__(self, types: tuple[type, type], apart: int) -> None:
        self.types, self.functions = types, OF_TYPES[types][::apart]
        self.forms = [plain_form(function, types, None) for function in self.functions]  # type: ignore[arg-type]
        assert not [problem for form in self.forms for problem in form.problems]

    def __call__(self, a: list[Number], b: list[Number]) -> list[list[Outcome]]:
        """Outcomes of each function for each pair of operands."""
        dtypes = {float: np.float64, int: np.int64}
        given = [np.array(v, dtype=dtypes[kind]) for v, kind in zip((a, b), self.types, strict=True)]
        return [self._outcomes(form, given) for form in self.forms]

    def _outcomes(self, form: Any, given: list[Any]) -> list[Outcome]:
        value, fault = over_columns(form.function, *given)
        failed = fault.tolist()
        return [(b"", True) if wrong else (bits(v), False) for v, wrong in zip(value.tolist(), failed, strict=True)]


@pytest.mark.exhaustive("float")
@TYPES
@pytest.mark.parametrize(("apart", "examples"), [(5, 50), pytest.param(1, 200, marks=pytest.mark.exhaustive)])
@pytest.mark.defect("S14", before="x ** 3, overflow, n // 0 differ in silence", after="the same bits, or the run ends")
def test_compiled_code_means_what_python_means(types: tuple[type, type], apart: int, examples: int) -> None:
    compiled = Compiled(types, apart)
    hostile = {int: HOSTILE_INTEGERS, float: HOSTILE_NUMBERS}
    agree(compiled, [(a, b) for a in hostile[types[0]] for b in hostile[types[1]]])

    @settings(max_examples=examples)
    @given(st.lists(st.tuples(OPERANDS[types[0]], OPERANDS[types[1]]), min_size=1, max_size=40))
    def drawn(pairs: list[tuple[Number, Number]]) -> None:
        agree(compiled, pairs)

    drawn()


@pytest.mark.defect("S709", before="in machine code min((2^53 + 1, 2^53 + 3)) was 2^53", after="all digits of integers")
def test_the_least_and_the_largest_entry_have_all_their_digits() -> None:
    for function, expected in ((least_entry, 2**53 + 1), (largest_entry, 2**53 + 3)):
        form = plain_form(function, (int, int), None)  # type: ignore[arg-type]
        values, faults = over_columns(form.function, np.array([2**53 + 1]), np.array([2**53 + 3]))
        assert (values.dtype, values.tolist(), faults.tolist()) == (np.int64, [expected], [False])


def test_a_shift_fails_where_its_result_has_more_than_64_bits() -> None:
    for a in HOSTILE_INTEGERS:
        for b in (-1, 0, 1, 31, 62, 63, 64, 1000):
            assert arithmetic.shift_left_fails(a, b) == (b < 0 or not -(2**63) <= a * 2**b < 2**63), (a, b)


def test_plain_python_ends_a_loop_at_the_same_turn() -> None:
    """The turns are counted by hand: a loop of 2^24 turns would take seconds."""
    last = arithmetic.MOST_TURNS - 1
    assert TURN.reference(last) == TURN.value(last) == arithmetic.MOST_TURNS
    assert TURN.fails(last + 1)
    assert not TURN.fails(last)
    with pytest.raises(RuntimeError, match="a loop of over 16,777,216 turns in one tick"):
        TURN.reference(last + 1)


def guarded(a: float, b: float) -> float:
    return a / b if b != 0.0 else 0.0


def guarded_root(a: float, b: float) -> float:
    return math.sqrt(a) + b if a >= 0.0 else b


@pytest.mark.parametrize("function", [guarded, guarded_root])
def test_what_would_fail_in_the_other_case_does_not_fail(function: Callable[[float, float], float]) -> None:
    columns = np.array([[4.0, -4.0, 9.0, -1.0], [2.0, 0.0, 0.0, 0.5]])
    form = plain_form(function, (float, float), None)  # type: ignore[arg-type]
    values, faults = over_columns(form.function, *columns)
    assert values.tolist() == [function(a, b) for a, b in columns.T.tolist()]
    assert not faults.any()


def least_entry(a: int, b: int) -> int:
    return min((a, b))


def largest_entry(a: int, b: int) -> int:
    return max((a, b))


def agree(compiled: Compiled, pairs: list[tuple[Number, Number]]) -> None:
    found = compiled([a for a, _ in pairs], [b for _, b in pairs])
    for function, outcomes in zip(compiled.functions, found, strict=True):
        for (a, b), outcome in zip(pairs, outcomes, strict=True):
            assert outcome == python(function, a, b), f"{function.__name__}({a!r}, {b!r})"


@pytest.mark.exhaustive("int and int", "float and float")
@TYPES
@settings(max_examples=300)
@given(data=st.data())
def test_plain_python_raises_where_compiled_code_notes_a_fault(types: tuple[type, type], data: st.DataObject) -> None:
    a, b = (data.draw(OPERANDS[kind]) for kind in types)
    for function in OF_TYPES[types]:
        form = plain_form(function, types, None)  # type: ignore[arg-type]
        try:
            outcome = bits(form.function(a, b)), False
        except (ArithmeticError, ValueError, IndexError):
            outcome = b"", True
        assert outcome == python(function, a, b), f"{function.__name__}({a!r}, {b!r})"
