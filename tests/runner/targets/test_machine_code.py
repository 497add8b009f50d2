"""Machine code of programs: Python's bits for every operation and statement, kept safely, without fused arithmetic."""

import os
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
import numpy as np
import pytest

from proofmass.runner.program.form import FLOAT, INTEGER, OPERATIONS, TRUTH, External, Function, Program, Value
from proofmass.runner.targets import machine_code
from proofmass.runner.targets.llvm_text import llvm_text
from tests.by_hand.hostile_operations import (
    PYTHON,
    THIN,
    THINNER,
    operations_arrays,
    operations_program,
    operations_wrong,
    select_program,
)
from tests.by_hand.programs import Writer, program
from tests.by_hand.small_programs import SMALL, Case, of_libm
from tests.by_hand.verify_program import verify

LEVELS = (machine_code.Settings(level=0), machine_code.ALONE, machine_code.Settings(rows=True, wide=True))


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache folder of the test's own, and a process that has loaded nothing."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("PROOFMASS_CACHE", str(folder))
    monkeypatch.setattr(machine_code, "_loaded", {})
    return folder


def run(made: Program, arrays: list[Any], settings: machine_code.Settings = machine_code.ALONE) -> None:
    """Run a program whose entry takes arrays alone."""
    verify(made)
    machine_code.load(made, settings)(*(array.ctypes.data for array in arrays))


def test_python_knows_every_operation() -> None:
    assert PYTHON.keys() | {"select"} == OPERATIONS.keys()


@pytest.mark.parametrize("settings", LEVELS, ids=str)
@pytest.mark.parametrize("constant", [None, 0, 1])
@pytest.mark.parametrize("thin", [THINNER, pytest.param(THIN, marks=pytest.mark.exhaustive)])
def test_operations_on_hostile_values(thin: int, constant: int | None, settings: machine_code.Settings) -> None:
    arrays = operations_arrays()
    run(operations_program(constant, thin), arrays, settings)
    assert not operations_wrong(arrays, constant, thin)


@pytest.mark.parametrize("likely", [False, True])
@pytest.mark.parametrize("condition", [False, True])
def test_selections(condition: bool, likely: bool) -> None:
    arrays = [np.array([1.5, -0.0, 9.0]), np.array([7, -8, 9]), np.array([True, False, True])]
    machine_code.load(select_program(likely))(condition, *(array.ctypes.data for array in arrays))
    assert [array[2] for array in arrays] == [array[1 - condition] for array in arrays]


@pytest.mark.parametrize("settings", LEVELS, ids=str)
@pytest.mark.parametrize("case", [*SMALL.values(), of_libm])
def test_statements(case: Callable[[], Case], settings: machine_code.Settings) -> None:
    made, before, behind = case()
    run(made, before, settings)
    for array, expected in zip(before, behind, strict=True):
        assert array.tobytes() == expected.tobytes(), (array, expected)


@pytest.mark.parametrize(("kind", "values"), [(FLOAT, (1.5, -0.0)), (INTEGER, (5, -(2**63))), (TRUTH, (True, False))])
def test_the_entry_takes_and_returns_numbers(kind: Any, values: tuple[Any, ...]) -> None:
    x = Value(kind, "x")
    w = Writer("entry", x, results=(kind,))
    w.leave(x)
    function = machine_code.load(program(w.function))
    assert [repr(function(value)) for value in values] == [repr(value) for value in values]


def test_a_function_that_has_an_address_is_called_there() -> None:
    import ctypes

    seen: list[int] = []
    prototype = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64)
    callback = prototype(lambda n: seen.append(n) or 2 * n)
    address = ctypes.cast(callback, ctypes.c_void_p).value
    model = External("model_of_a_test", (INTEGER,), INTEGER, address, pure=False)
    w = Writer("entry", results=(INTEGER,))
    w.call(model, 1)
    w.leave(*w.call(model, 21))
    assert machine_code.load(program(w.function))() == 42
    assert seen == [1, 21]


def test_loops_that_compute_from_turn_to_turn_are_written_out() -> None:
    """Counters of the others are chosen by where a turn comes from."""
    assert "phi i64" not in llvm_text(SMALL["carried"]()[0])
    assert "phi i64" in llvm_text(SMALL["primes"]()[0])


def test_long_regions_are_compiled_in_parts() -> None:
    """Behind so many statements a block of instructions ends, in a loop and outside of one."""
    n, x = Value(INTEGER, "n"), Value(FLOAT, "x")
    w = Writer("entry", n, x, results=(FLOAT,))
    v = w.variable(FLOAT, "v")
    value, expected = x, 0.5

    def long(value: Value, number: float) -> tuple[Value, float]:
        for step in range(1100):
            value, number = w.do("add", w.do("multiply", value, 0.999), 0.1 * step), number * 0.999 + 0.1 * step
        return value, number

    value, expected = long(value, expected)
    w.set(v, value)
    with w.count(0, n):
        value, _ = long(w.get(v), 0.0)
        w.set(v, value)
    w.leave(w.get(v))
    for _ in range(3):
        for step in range(1100):
            expected = expected * 0.999 + 0.1 * step
    text = llvm_text(program(w.function))
    assert text.count("asm sideeffect") == 4
    assert machine_code.load(program(w.function))(3, 0.5) == expected


# -- the cache ---------------------------------------------------------------------------------------------------------


def tripled(factor: float = 3.0) -> Program:
    """A program of one multiplication."""
    x = Value(FLOAT, "x")
    w = Writer("entry", x, results=(FLOAT,))
    w.leave(w.do("multiply", x, factor))
    return program(w.function)


def key(made: Program) -> str:
    return machine_code.key_of(llvm_text(made))


def test_the_second_time_it_is_loaded(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert machine_code.load(tripled())(2.0) == 6.0
    assert machine_code.is_cached(key(tripled()))
    machine_code._loaded.clear()
    monkeypatch.setattr(machine_code, "object_code", None)
    assert machine_code.load(tripled())(2.0) == 6.0
    assert [path.suffix for path in cache.iterdir()] == [".o"]


def test_other_programs_settings_and_processors_have_other_keys(monkeypatch: pytest.MonkeyPatch) -> None:
    keys = {key(tripled()), key(tripled(4.0))}
    keys |= {machine_code.key_of(llvm_text(tripled()), settings) for settings in LEVELS}
    monkeypatch.setattr(llvm, "get_host_cpu_name", lambda: "another")
    keys.add(key(tripled()))
    assert len(keys) == 5


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: b"",
        lambda data: data[:20],
        lambda data: data[: len(data) // 2],
        lambda data: data[:100] + bytes([data[100] ^ 1]) + data[101:],
        lambda data: b"\0" * len(data),
        lambda data: data + b"more",
    ],
    ids=["empty", "in the digest", "half", "one bit", "zeros", "longer"],
)
def test_a_damaged_file_is_made_anew(cache: Path, damage: Any) -> None:
    assert machine_code.load(tripled())(2.0) == 6.0
    [path] = cache.glob("*.o")
    whole = path.read_bytes()
    path.write_bytes(damage(whole))
    machine_code._loaded.clear()
    assert not machine_code.is_cached(path.stem)
    assert machine_code.load(tripled())(2.0) == 6.0
    assert path.read_bytes() == whole


@pytest.mark.parametrize("mode", [0o700, 0o770, 0o707, 0o777, 0o1777])
def test_a_forgery_is_not_read_from_a_folder_that_others_could_write_to(cache: Path, mode: int) -> None:
    for factor in (3.0, 4.0):
        machine_code.load(tripled(factor))
    shutil.copy(cache / f"{key(tripled(4.0))}.o", cache / f"{key(tripled())}.o")
    cache.chmod(mode)
    machine_code._loaded.clear()
    assert machine_code.load(tripled())(2.0) == (8.0 if mode == 0o700 else 6.0)  # with the user's own mode it works


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="owners are of POSIX")
def test_a_folder_of_another_owner_is_not_read(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for factor in (3.0, 4.0):
        machine_code.load(tripled(factor))
    shutil.copy(cache / f"{key(tripled(4.0))}.o", cache / f"{key(tripled())}.o")
    machine_code._loaded.clear()
    owner = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: owner + 1)
    assert machine_code.load(tripled())(2.0) == 6.0


def test_a_folder_that_cannot_be_written_is_no_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("PROOFMASS_CACHE", str(tmp_path / "file" / "cache"))
    assert machine_code.load(tripled())(2.0) == 6.0


# -- what the code consists of -----------------------------------------------------------------------------------------


def oscillator() -> Function:
    """Products that are added to, in a loop."""
    x, n = Value(FLOAT, "x"), Value(INTEGER, "n")
    w = Writer("entry", x, n, results=(FLOAT,))
    position, velocity = w.variable(FLOAT, "position"), w.variable(FLOAT, "velocity")
    w.set(position, x)
    with w.count(0, n):
        w.set(velocity, w.do("subtract", w.get(velocity), w.do("multiply", w.get(position), 0.01)))
        w.set(position, w.do("add", w.get(position), w.do("multiply", w.get(velocity), 0.01)))
    w.leave(w.get(position))
    return w.function


@pytest.mark.skipif(not shutil.which("objdump"), reason="needs objdump")
@pytest.mark.parametrize("settings", LEVELS, ids=str)
def test_nothing_is_fused(tmp_path: Path, settings: machine_code.Settings) -> None:
    if not {"fma", "neon"} & {name for name, has in llvm.get_host_cpu_features().items() if has}:
        pytest.skip("this processor could not fuse")
    file = tmp_path / "code.o"
    file.write_bytes(machine_code.object_code(llvm_text(program(oscillator())), settings))
    text = subprocess.run(["objdump", "-dt", str(file)], capture_output=True, text=True, check=True).stdout
    assert re.search(r"\b(v?mulsd|fmul)\b", text), "a loop without a multiplication is not this one"
    assert not re.search(r"\b(v?fn?m(add|sub)|fmla|fmls)", text)
    assert set(re.findall(r"\*UND\*\s+\S+\s+(\S+)", text)) <= {"_GLOBAL_OFFSET_TABLE_"}


def test_a_function_of_the_c_library_stays_what_it_is() -> None:
    text = llvm_text(of_libm()[0])
    assert "declare double @proofmass_pow(double, double)" in text
