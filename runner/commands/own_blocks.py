"""Blocks from a Python file of the user's own, as `--blocks` names it."""

import traceback
from pathlib import Path
from typing import TYPE_CHECKING

from proofmass.blocks.declaration.problem import ModelError, Problem

if TYPE_CHECKING:
    from proofmass.blocks.declaration.declare import Block


def own_blocks(path: Path | None) -> "dict[str, type[Block]] | None":
    """Return the blocks of a file, which is run, or None without one; raises `ModelError` if the file fails."""
    if path is None:
        return None
    # start-up time: only --blocks needs the catalogue
    from proofmass.blocks.declaration.catalog import load_own_blocks

    try:
        return load_own_blocks(path)
    except ModelError:
        raise
    except Exception as error:
        message = f"the file of blocks fails: {type(error).__name__}: {getattr(error, 'msg', error)}"
        raise ModelError([Problem(message=message, file=str(path), line=_line(error, path))]) from error


def _line(error: Exception, path: Path) -> int:
    """The line of the file at which an error arose, 0 if it is not known."""
    if isinstance(error, SyntaxError):
        return error.lineno or 0
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if Path(frame.filename).resolve() == path.resolve()]
    return lines[-1] or 0 if lines else 0
