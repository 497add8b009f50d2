"""Clipping for bounds that are seldom reached: the same as clipping, by branches in machine code."""

import math
from itertools import product
from typing import Any

import numpy as np
import pytest

from proofmass.blocks.arithmetic.rounding import clip, saturated
from proofmass.runner.program.build import Builder
from proofmass.runner.program.form import FLOAT, Program
from proofmass.runner.program.lower import call, program
from proofmass.runner.targets import machine_code
from proofmass.runner.targets.llvm_text import llvm_text

HOSTILE = (math.nan, math.inf, -math.inf, 0.0, -0.0, 5e-324, -1.0, 1.0, 1.0000000000000002, -1.7e308)
CASES = np.array(list(product(HOSTILE, repeat=3)))


def looped(function: Any) -> Program:
    """A function of three numbers for each row of an array; its results stand in another one."""
    builder = Builder("entry", "rows")
    given, made = builder.array(FLOAT, None, "given"), builder.array(FLOAT, None, "made", writable=True)
    with builder.counted(0, len(CASES)) as row:
        first = builder.compute("multiply_integers", row, 3)
        numbers = [builder.load(given, builder.compute("add_integers", first, place)) for place in range(3)]
        builder.store(made, row, call(builder, function, numbers))
    return program(builder.function())


@pytest.mark.parametrize("function", [clip, saturated])
def test_clipping_of_hostile_numbers(function: Any) -> None:
    made = np.zeros(len(CASES))
    machine_code.load(looped(function))(CASES.ctypes.data, made.ctypes.data)
    expected = np.array([low if not value > low else value for value, low, _ in CASES.tolist()])
    expected = np.where(expected < CASES[:, 2], expected, CASES[:, 2])
    assert made.tobytes() == expected.tobytes()
    assert np.array([function(*case) for case in CASES.tolist()]).tobytes() == expected.tobytes()


@pytest.mark.parametrize(("function", "expected"), [(clip, 0), (saturated, 2)])
def test_machine_code_is_told_of_bounds_that_are_seldom_reached(function: Any, expected: int) -> None:
    text = llvm_text(looped(function))
    assert text.count("= select") == 2
    assert text.count(", !prof !0") == expected
