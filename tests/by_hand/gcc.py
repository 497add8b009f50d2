"""Compiles C of programs by gcc, as strictly as it can, and calls it."""

import ctypes
import shutil
from pathlib import Path
from typing import Any

import pytest

from proofmass.runner.contract.foreign import C99
from proofmass.runner.program.form import Program

needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
_STRICT = ("-pedantic-errors", "-Wall", "-Wextra", "-Werror")
_MADE = ("variable", "parameter", "but-set-variable", "function")  # what may be unused
_UNUSED = (*(f"-Wno-unused-{what}" for what in _MADE), "-Wno-tautological-compare")


def compiled_by_gcc(made: Program, folder: Path, level: str = "-O1") -> Any:
    """The entry of a program, compiled by gcc."""
    return C99().compiled(made, folder, (*_STRICT, *_UNUSED, level))


def run_in_c(function: Any, arrays: list[Any], *numbers: int) -> None:
    """Call an entry of integers and arrays."""
    function(*map(ctypes.c_int64, numbers), *(ctypes.c_void_p(array.ctypes.data) for array in arrays))
