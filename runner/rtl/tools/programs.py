"""Programs of others, used where they are found."""

import os
import shutil
import sys
from pathlib import Path

from proofmass.blocks.declaration.problem import ModelError, Problem

_BESIDE = str(Path(sys.executable).parent)  # where pip puts programs, of an environment that need not be active


def found(*programs: str) -> str | None:
    """The path of the first of them that is on the PATH or beside the running Python."""
    return next((path for name in programs if (path := shutil.which(name, path=search_path()))), None)


def search_path() -> str:
    """The PATH, and behind it the folder of the running Python."""
    return os.pathsep.join((os.environ.get("PATH", os.defpath), _BESIDE))


def need_program(*programs: str, purpose: str, hint: str) -> str:
    """The path of the first that is found; raises `ModelError` with what to install."""
    path = found(*programs)
    if path is None:
        raise ModelError([Problem(message=f"{programs[0]} is not installed: it {purpose}", hint=hint)])
    return path
