"""Programs as C99: compiled by gcc they compute the bits of the reference, and they can be read."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from proofmass.runner.program.form import (
    FLOAT,
    INTEGER,
    Compute,
    Function,
    Immediate,
    Line,
    Return,
    Storage,
    Value,
)
from proofmass.runner.targets import machine_code
from proofmass.runner.targets.c99 import c99_text
from tests.by_hand.gcc import compiled_by_gcc, needs_gcc, run_in_c
from tests.by_hand.hostile_operations import (
    THIN,
    THINNER,
    operations_arrays,
    operations_program,
    operations_wrong,
    select_program,
)
from tests.by_hand.programs import Writer, program
from tests.by_hand.random_programs import RandomProgram, random_arrays
from tests.by_hand.small_programs import SMALL, Case, of_libm


@pytest.mark.exhaustive("35-0--O1", "35-1--O1")
@needs_gcc
@pytest.mark.parametrize(("constant", "level"), [(None, "-O0"), (None, "-O3"), (0, "-O1"), (1, "-O1")])
@pytest.mark.parametrize("thin", [THINNER, pytest.param(THIN, marks=pytest.mark.exhaustive)])
def test_operations_on_hostile_values(thin: int, constant: int | None, level: str, tmp_path: Path) -> None:
    arrays = operations_arrays()
    run_in_c(compiled_by_gcc(operations_program(constant, thin), tmp_path, level), arrays)
    assert not operations_wrong(arrays, constant, thin)


@needs_gcc
@pytest.mark.parametrize("likely", [False, True])
@pytest.mark.parametrize("condition", [False, True])
def test_selections(condition: bool, likely: bool, tmp_path: Path) -> None:
    arrays = [np.array([1.5, -0.0, 9.0]), np.array([7, -8, 9]), np.array([True, False, True])]
    run_in_c(compiled_by_gcc(select_program(likely), tmp_path), arrays, condition)
    assert [array[2] for array in arrays] == [array[1 - condition] for array in arrays]


@needs_gcc
@pytest.mark.parametrize("level", ["-O0", "-O3"])
@pytest.mark.parametrize("case", [*SMALL.values(), of_libm])
def test_statements(case: Callable[[], Case], level: str, tmp_path: Path) -> None:
    made, before, behind = case()
    run_in_c(compiled_by_gcc(made, tmp_path, level), before)
    for array, expected in zip(before, behind, strict=True):
        assert array.tobytes() == expected.tobytes(), (array, expected)


@pytest.mark.exhaustive(but=8)
@needs_gcc
@pytest.mark.parametrize("seed", range(20))
def test_random_programs_have_the_bits_of_machine_code(
    seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PROOFMASS_CACHE", str(tmp_path))
    made, arrays, others = RandomProgram(seed).program, random_arrays(seed), random_arrays(seed)
    run_in_c(compiled_by_gcc(made, tmp_path), arrays, 3)
    machine_code.load(made)(3, *(array.ctypes.data for array in others))
    for one, other in zip(arrays, others, strict=True):
        np.testing.assert_array_equal(one, other)
        if one.dtype == np.float64:
            np.testing.assert_array_equal(np.signbit(one[~np.isnan(one)]), np.signbit(other[~np.isnan(one)]))


def test_it_can_be_read(tmp_path: Path) -> None:
    file = tmp_path / "spring.py"
    file.write_text("def force(x, v):\n    pull = 3.0 * x\n    return -pull - 2.0 * v  # comments: /* */\n")
    x, v, pull = Value(FLOAT, "x"), Value(FLOAT, "double"), Value(FLOAT, "pull")
    first, second = Line(str(file), 2), Line(str(file), 3)
    parts = [Value(FLOAT) for _ in range(3)]
    body = [
        Compute(pull, "multiply", (Immediate(FLOAT, 3.0), x), first),
        Compute(parts[0], "negate", (pull,), second),
        Compute(parts[1], "multiply", (Immediate(FLOAT, 2.0), v), second),
        Compute(parts[2], "subtract", (parts[0], parts[1]), second),
        Return((parts[2],), second),
    ]
    text = c99_text(program(Function("force", (x, v), (FLOAT,), body, origin="spring.force")))
    assert text == (
        "#include <math.h>\n#include <stdbool.h>\n#include <stdint.h>\n#include <string.h>\n\n"
        "/* spring.force */\n"
        "double force(double x, double double_2)\n"
        "{\n"
        f"{'    return (-(3.0 * x)) - (2.0 * double_2);':88}"
        "/* spring.py:3  return -pull - 2.0 * v  # comments: / * * / */\n"
        "}\n"
    )


def test_only_helpers_that_are_called_are_written() -> None:
    a = Storage(INTEGER, 2, True, "a")
    w = Writer("entry", a)
    w.store(a, 0, w.do("floor_divide", w.load(a, 1), 3))
    text = c99_text(program(w.function), "step")
    assert "floor_divide(int64_t a" in text
    assert "modulo" not in text
    assert "void step(int64_t *restrict a)" in text
