"""Steps of digital blocks in fixed point: the reference, its integer code and the compiled loop are equal.

Each is also held against the same block in exact or floating-point numbers, within its rounding.
"""

from collections.abc import Callable
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.signal import lfilter

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, counting_overflows, fixed, where, wrap
from proofmass.runner.fixed.step_formats import reference_step
from tests.by_hand.amounts import amounts
from tests.by_hand.compiled import compiled
from tests.by_hand.integer_code import compile_step

TICKS = amounts(600, 20_000)
REFERENCE_TICKS = 400

# -- integrator ----------------------------------------------------------------------------------------------------


class IntegratorState(NamedTuple):
    total: Any


INTEGRATOR = {
    "c": fixed(0.01, Fixed(16, 20), "half_even"),
    "x": IntegratorState(Fixed(24, 18)),
    "input": Fixed(16, 12),
    "return": (IntegratorState(Fixed(24, 18)), Fixed(16, 10)),
}


def integrator(c: FixedValue, x: IntegratorState, input: FixedValue) -> tuple[IntegratorState, FixedValue]:
    """total[n+1] = total[n] + gain input[n], saturated."""
    return IntegratorState((x.total + c * input).to(Fixed(24, 18))), x.total.to(Fixed(16, 10), "half_up")


# -- state space ---------------------------------------------------------------------------------------------------

STATE = Fixed(32, 26)
TRANSITION = ((0.99, 0.05, 0.0), (-0.05, 0.98, 0.01), (0.0, -0.02, 0.9))
ENTRY = (0.01, 0.05, 0.2)


class Vector(NamedTuple):
    first: Any
    second: Any
    third: Any


STATE_SPACE = {"x": Vector(STATE, STATE, STATE), "u": Fixed(16, 14), "return": (Vector(STATE, STATE, STATE), STATE)}


def state_space(x: Vector, u: FixedValue) -> tuple[Vector, FixedValue]:
    """x[n+1] = A x[n] + B u[n], y = the first state; coefficients of 18 bits."""
    moved = []
    for row, entry in zip(TRANSITION, ENTRY, strict=True):
        total = fixed(entry, Fixed(18, 16), "half_even") * u
        for factor, value in zip(row, x, strict=True):
            total = total + fixed(factor, Fixed(18, 16), "half_even") * value
        moved.append(total.to(STATE, "half_even"))
    return Vector(*moved), x.first


# -- PID with a plain if -------------------------------------------------------------------------------------------

ERROR, OUTPUT, SUM = Fixed(16, 4), Fixed(16, 6), Fixed(36, 22)


class PidState(NamedTuple):
    integral: Any
    derivative: Any
    error: Any


class PidConstants(NamedTuple):
    proportional: Any
    integral: Any
    derivative: Any
    decay: Any


GAINS = PidConstants(*(fixed(g, Fixed(18, 16), "half_even") for g in (0.6, 0.02, 1.3, 0.75)))
PID_STATE = PidState(SUM, SUM, ERROR)
PID = {"c": PidConstants(*[Fixed(18, 16)] * 4), "x": PID_STATE, "error": ERROR, "return": (PID_STATE, OUTPUT)}


def pid(c: PidConstants, x: PidState, error: FixedValue) -> tuple[PidState, FixedValue]:
    """Filtered derivative, and an integral that stops where the output is at its limits."""
    derivative = (c.decay * x.derivative + c.derivative * (error - x.error)).to(SUM, "half_up")
    integral = (x.integral + c.integral * error).to(SUM, "half_up")
    wanted = c.proportional * error + integral + derivative
    if wanted > 400 and error > 0:
        wanted, integral = FixedValue(400), x.integral
    elif wanted < -400 and error < 0:
        wanted, integral = FixedValue(-400), x.integral
    return PidState(integral, derivative, error), wanted.to(OUTPUT)


# -- shift register and correlation cells --------------------------------------------------------------------------


class CellState(NamedTuple):
    register: Any
    chip: Any


WORD, COUNT, CODE, CELL = Fixed(10, 0, signed=False), Fixed(10, 0, signed=False), Fixed(12), Fixed(22)
CELLS = {
    "x": CellState(WORD, COUNT),
    "code": CODE,
    "history": [Fixed(1)] * 4,
    "sums": [CELL] * 4,
    "return": (CellState(WORD, COUNT), bool),
}


def cells(x: CellState, code: FixedValue, history: list[FixedValue], sums: list[FixedValue]) -> tuple[CellState, Any]:
    """Chips of a 10-bit shift register, and sums of plus or minus the code over a period of 1023 of them."""
    word = x.register.mantissa
    bit = word & 1
    history[:] = [FixedValue(-bit), *history[:-1]]
    for k in range(len(sums)):
        last = where(x.chip == 0, FixedValue(0), sums[k])
        sums[k] = wrap(last + where(history[k] != 0, code, -code), CELL)
    feedback = (word ^ (word >> 3)) & 1
    moved = FixedValue((word >> 1) | (feedback << 9))
    return CellState(moved, where(x.chip == 1022, 0, wrap(x.chip + 1, COUNT))), bit == 1


# -- all of them ---------------------------------------------------------------------------------------------------

Case = tuple[Callable[..., Any], dict[str, Any], Any, Any, list[list[int]]]
CASES: dict[str, Case] = {
    "integrator": (integrator, INTEGRATOR, 0, IntegratorState(0), []),
    "state space": (state_space, STATE_SPACE, None, Vector(0, 0, 0), []),
    "pid": (pid, PID, PidConstants(*(g.mantissa for g in GAINS)), PidState(0, 0, 0), []),
    "cells": (cells, CELLS, None, CellState(0x3FF, 0), [[0] * 4, [0] * 4]),
}


def run_step(step: Callable[..., Any], case: Case, inputs: np.ndarray) -> list[Any]:
    """State and output of every tick; the step is that of mantissas."""
    _, formats, constants, x, buffers = case
    first = [constants] if "c" in formats else []
    buffers = [list(buffer) for buffer in buffers]
    rows = []
    for u in inputs.tolist():
        x, y = step(*first, x, u, *buffers)
        rows.append((x, y, *map(tuple, buffers)))
    return rows


def compiled_outputs(case: Case, inputs: np.ndarray) -> np.ndarray:
    """Outputs of the step compiled into a loop."""
    function, formats, constants, x, buffers = case
    step = compiled(compile_step(function, formats))
    out = np.zeros(len(inputs), np.int64)
    first = (constants,) if "c" in formats else ()
    arrays = tuple(np.array(buffer) for buffer in buffers)
    for i, u in enumerate(inputs.tolist()):
        x, out[i] = step(*first, x, u, *arrays)
    return out


def inputs_of(name: str, count: int) -> np.ndarray:
    format = {"integrator": Fixed(16, 12), "state space": Fixed(16, 14), "pid": ERROR, "cells": CODE}[name]
    level = np.random.default_rng(5).integers(format.lowest, format.highest, count, endpoint=True)
    slow = np.sign(np.sin(np.arange(count) / 60.0)) * format.highest // 2
    found: np.ndarray = (level // 4 + slow).astype(np.int64)
    return found  # stays on one side long enough to reach the limits


@pytest.mark.exhaustive(but=2)
@pytest.mark.parametrize("ticks", TICKS)
@pytest.mark.parametrize("name", CASES)
def test_three_engines_agree(name: str, ticks: int) -> None:
    case = CASES[name]
    inputs = inputs_of(name, ticks)
    code = compile_step(case[0], case[1])
    plain = run_step(code, case, inputs)
    assert run_step(reference_step(case[0], case[1]), case, inputs[:REFERENCE_TICKS]) == plain[:REFERENCE_TICKS]
    assert compiled_outputs(case, inputs).tolist() == [row[1] for row in plain]


@pytest.mark.exhaustive
def test_the_integrator_against_exact_sums_and_its_limits() -> None:
    inputs = np.repeat(inputs_of("integrator", 800)[::20], 1000)
    rows = run_step(compile_step(integrator, INTEGRATOR), CASES["integrator"], inputs)
    total, expected = 0, []
    for u in inputs.tolist():
        total = min(max(round(total + Fraction(10486 * u, 2**14)), -(2**23)), 2**23 - 1)
        expected.append(total)
    assert INTEGRATOR["c"].mantissa == 10486 == round(0.01 * 2**20)  # type: ignore[attr-defined]
    assert [row[0].total for row in rows] == expected
    assert (min(expected), max(expected)) == (-(2**23), 2**23 - 1)


def test_saturations_are_counted_alike() -> None:
    step = compile_step(integrator, INTEGRATOR, count_overflows=True)
    reference = reference_step(integrator, INTEGRATOR)
    code = compiled(step)
    for total in (-(2**23), -(2**23) + 5, 0, 2**23 - 5, 2**23 - 1):
        for u in (-(2**15), -1, 0, 1, 2**15 - 1):
            with counting_overflows() as overflows:
                expected = reference(0, IntegratorState(total), u)
            assert step(0, IntegratorState(total), u) == (expected, overflows.total)
            assert code(0, IntegratorState(total), u) == (expected, overflows.total)


@pytest.mark.parametrize("ticks", TICKS)
def test_the_state_space_against_floating_point(ticks: int) -> None:
    inputs = inputs_of("state space", ticks)
    rows = run_step(compile_step(state_space, STATE_SPACE), CASES["state space"], inputs)
    grid = 2.0**-16
    transition, entry = (np.round(np.array(m) / grid) * grid for m in (TRANSITION, ENTRY))
    x, worst = np.zeros(3), 0.0
    for row, u in zip(rows, inputs.tolist(), strict=True):
        x = transition @ x + entry * (u / 2**14)
        worst = max(worst, float(np.abs(x - np.array(row[0]) / 2**26).max()))
    assert 0 < worst < 60 * 2.0**-27  # half a step in each tick, times the sum of the impulse response


def test_the_pid_against_its_difference_equation() -> None:
    errors = inputs_of("pid", 200) // 400
    rows = run_step(compile_step(pid, PID), CASES["pid"], errors)
    kp, ki, kd, a = (float(g) for g in GAINS)
    e = errors / 16.0
    expected = kp * e + lfilter([ki], [1.0, -1.0], e) + lfilter([kd, -kd], [1.0, -a], e)
    assert np.array([row[1] for row in rows]) / 64.0 == pytest.approx(expected, abs=0.5 / 64 + 1e-4)


@pytest.mark.exhaustive
def test_the_cells_against_whole_sums() -> None:
    codes = inputs_of("cells", 3 * 1023)
    rows = run_step(compile_step(cells, CELLS), CASES["cells"], codes)
    bits = np.array([row[1] for row in rows], bool)
    assert bits[:10].all()
    assert bits[:1023].sum() == 512
    assert np.array_equal(bits[:1023], bits[1023:2046])
    for k in range(4):
        signs = np.where(np.roll(bits, k)[1023:2046], 1, -1)
        assert rows[2045][3][k] == (signs * codes[1023:2046]).sum()
