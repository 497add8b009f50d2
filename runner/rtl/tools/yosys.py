"""Yosys on files of a folder, in a separate process: an error of Yosys ends its process."""

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from proofmass.blocks.declaration.libraries import need
from proofmass.blocks.declaration.problem import Problem

_PROGRAM = """\
import sys
from pyosys import libyosys
design = libyosys.Design()
for command in sys.argv[1:]:
    libyosys.run_pass(command, design)
"""


def run_yosys(folder: Path, commands: Sequence[str]) -> None:
    """Run commands of Yosys, which name files of the folder; raises `ModelError` with the message of Yosys."""
    need("pyosys")
    ended = subprocess.run(
        [sys.executable, "-c", _PROGRAM, *commands], cwd=folder, capture_output=True, text=True, check=False
    )
    if ended.returncode:
        said = [line for line in (ended.stdout + ended.stderr).splitlines() if line.strip()]
        error = next((line for line in said if "ERROR" in line), said[-1] if said else f"exit {ended.returncode}")
        raise Problem(message="Yosys refuses the Verilog", got=error, hint=f"the command: {commands[-1]}").error
