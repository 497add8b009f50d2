"""Names of files in errors of the disk: Python names a file that it cannot open, not one that it cannot write to."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def named(path: str | Path) -> Iterator[None]:
    """Have an error of the disk name the file that it is about. Raises `OSError`."""
    try:
        yield
    except OSError as error:
        if error.errno is None:  # libraries have words alone: "1000 requested and 46 written"
            raise OSError(errno.EIO, str(error), str(path)) from error
        error.filename, error.filename2 = str(path), None
        raise


def write_text(path: Path, text: str) -> None:
    """Write a text to a file; raises `OSError`, with its name."""
    with named(path):
        path.write_text(text, encoding="utf-8")
