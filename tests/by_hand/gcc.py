"""Compiles C of programs by gcc and calls it."""

import ctypes
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from proofmass.runner.program.form import Program
from proofmass.runner.targets.c99 import c99_text

GCC = shutil.which("gcc")
needs_gcc = pytest.mark.skipif(GCC is None, reason="needs gcc")
_STRICT = ("-std=c99", "-ffp-contract=off", "-pedantic-errors", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared")
_MADE = ("variable", "parameter", "but-set-variable", "function")  # what may be unused
_UNUSED = (*(f"-Wno-unused-{what}" for what in _MADE), "-Wno-tautological-compare")


def compiled_by_gcc(made: Program, folder: Path, level: str = "-O1") -> Any:
    """The entry of a program, compiled by gcc."""
    (folder / "program.c").write_text(c99_text(made, "entry"))
    files = ["-o", str(folder / "program.so"), str(folder / "program.c")]
    command = [GCC or "", *_STRICT, *_UNUSED, level, *files, "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return ctypes.CDLL(str(folder / "program.so")).entry


def run_in_c(function: Any, arrays: list[Any], *numbers: int) -> None:
    """Call an entry of integers and arrays."""
    function(*map(ctypes.c_int64, numbers), *(ctypes.c_void_p(array.ctypes.data) for array in arrays))
