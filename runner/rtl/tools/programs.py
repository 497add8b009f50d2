"""External programs, used if they are installed."""

import os
import shutil
import sys
from pathlib import Path

from proofmass.blocks.declaration.problem import Problem

_BESIDE = str(Path(sys.executable).parent)  # pip's programs, also if not activated


def found(*programs: str) -> str | None:
    """Return the path of the first program that is on the PATH or beside the running Python."""
    return next((path for name in programs if (path := shutil.which(name, path=search_path()))), None)


def search_path() -> str:
    """Return the PATH, followed by the folder of the running Python."""
    return os.pathsep.join((os.environ.get("PATH", os.defpath), _BESIDE))


def need_program(*programs: str, purpose: str, hint: str) -> str:
    """Return the path of the first program found; raises `ModelError` with what to install."""
    path = found(*programs)
    if path is None:
        raise Problem(message=f"{programs[0]} is not installed: it {purpose}", hint=hint).error
    return path
