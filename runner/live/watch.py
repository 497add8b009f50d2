"""Looks at files again and again, and says when one was saved."""

import threading
from collections.abc import Callable, Iterable
from pathlib import Path

_EVERY = 0.04  # seconds
_Facts = tuple[tuple[int, int, int], ...]


def watch(files: Callable[[], Iterable[Path]], saved: Callable[[], object], stop: threading.Event) -> None:
    """Call `saved` after each change of one of the files, until `stop` is set; a file under way is waited for."""
    names = tuple(files())
    before = facts_of(names)
    while not stop.wait(_EVERY):
        now = facts_of(names)
        if now == before:
            continue
        while not stop.wait(_EVERY / 2) and (later := facts_of(names)) != now:
            now = later
        if stop.is_set():
            return
        saved()
        known = dict(zip(names, now, strict=True))
        names = tuple(files())  # an edit may have added a part
        before = tuple(known.get(name) or _facts(name) for name in names)


def facts_of(files: Iterable[Path]) -> _Facts:
    """Time, size and place on the disk of each file; zeros for one that is not there."""
    return tuple(map(_facts, files))


def _facts(file: Path) -> tuple[int, int, int]:
    try:
        found = file.stat()
    except OSError:
        return 0, 0, 0
    return found.st_mtime_ns, found.st_size, found.st_ino
