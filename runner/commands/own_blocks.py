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
        raise Problem(message=message, file=str(path), line=_line(error, path)).error from error


def raised_by_own_block(error: Exception) -> ModelError | None:
    """Return what a function of a user's own block raised, with its file and line; None if none of them did."""
    # start-up time: few errors come here
    from proofmass.blocks.declaration.catalog import OWN

    walked = traceback.walk_tb(error.__traceback__)
    frames = [place for place in walked if str(place[0].f_globals.get("__name__", "")).startswith(OWN)]
    if not frames or isinstance(error, ModelError):
        return None
    frame, line = frames[-1]
    message = f"{frame.f_code.co_name}() of a block raises {type(error).__name__}: {error}"
    return Problem(message=message, file=frame.f_code.co_filename, line=line).error


def _line(error: Exception, path: Path) -> int:
    """The line of the file at which an error arose, 0 if it is not known."""
    if isinstance(error, SyntaxError):
        return error.lineno or 0
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if Path(frame.filename).resolve() == path.resolve()]
    return lines[-1] or 0 if lines else 0
