"""Assembles PTX by NVIDIA's own assembler, which needs no GPU: it checks every instruction, type and register.

`pip install nvidia-cuda-nvcc-cu12` brings it, 40 MB; where it is not there, what needs it is left out aloud.
"""

import importlib.util
import shutil
import subprocess
from pathlib import Path

import pytest


def _found() -> str | None:
    """The program, on the PATH or in NVIDIA's package."""
    spec = importlib.util.find_spec("nvidia")
    folders = spec.submodule_search_locations or () if spec else ()
    programs = (file for folder in folders for file in Path(folder).glob("*/bin/ptxas"))
    return shutil.which("ptxas") or next(map(str, programs), None)


PTXAS = _found()
needs_ptxas = pytest.mark.skipif(PTXAS is None, reason="needs ptxas")


def assembled(text: str, folder: Path, processor: str = "sm_80") -> bytes:
    """The machine code of a kernel for a kind of GPU; fails with what the assembler says."""
    assert PTXAS is not None
    source, made = folder / "kernel.ptx", folder / "kernel.cubin"
    source.write_text(text, encoding="ascii")
    command = [PTXAS, f"-arch={processor}", "--warning-as-error", "-o", str(made), str(source)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return made.read_bytes()
