"""Disks with little room, made by a limit on the size of files."""

import os
import resource
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


def little_room(size: int) -> dict[str, Any]:
    """What `subprocess.run` takes for a process that writes no file of more bytes.

    It writes no bytecode either: Python does not notice that it was cut off, and the next process would read it.
    """
    return {
        "preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)),
        "env": os.environ | {"PYTHONDONTWRITEBYTECODE": "1"},
    }


@contextmanager
def largest_file(size: int) -> Iterator[None]:
    """This process writes no file of more bytes, nor any bytecode."""
    before, bytecode = resource.getrlimit(resource.RLIMIT_FSIZE), sys.dont_write_bytecode
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    sys.dont_write_bytecode = True
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        sys.dont_write_bytecode = bytecode
