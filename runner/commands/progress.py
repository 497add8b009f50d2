"""A progress bar on a terminal, with results so far below it; nothing in a pipe."""

import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from proofmass.runner.output.times import time_text

ROWS = 8  # of results so far, at most


PATIENCE = 0.5  # seconds before anything is shown
PREPARING = "preparing: a graph is planned and compiled before its first run"


class Working:
    """A line on standard error that says what takes long; a context manager that erases it."""

    def __init__(self, what: str) -> None:
        self._what, self._shown = what, False
        self._lock = threading.Lock()
        self._timer = threading.Timer(PATIENCE, self._show)
        self._timer.daemon = True

    def __call__(self, what: str) -> None:
        """Say what is being done now."""
        with self._lock:
            self._what = what
            if self._shown:
                self._write("\r\x1b[J")

    def _show(self) -> None:
        with self._lock:
            if not self._timer.finished.is_set():
                self._shown = True
                self._write()

    def _write(self, erase: str = "") -> None:
        sys.stderr.write(erase + self._what[: shutil.get_terminal_size().columns - 1])
        sys.stderr.flush()

    def __enter__(self) -> "Working":
        self._timer.start()
        return self

    def __exit__(self, *error: object) -> None:
        with self._lock:
            self._timer.cancel()
            if self._shown:
                self._shown = False
                sys.stderr.write("\r\x1b[J")
                sys.stderr.flush()


@contextmanager
def working(quiet: bool, what: str) -> Iterator[Callable[[str], None]]:
    """Say what is being done where that takes long and standard error is a terminal; call it with what comes next."""
    if quiet or not sys.stderr.isatty():
        yield lambda what: None
    else:
        with Working(what) as line:
            yield line


class ProgressBar:
    """Draws how much is done, with rate and time left, on standard error; a context manager that erases itself."""

    def __init__(self, noun: str) -> None:
        self._noun = noun
        self._first: int | None = None  # done before, in an earlier start
        self._began = time.monotonic()
        self._drawn = 0.0
        self._erase = ""  # codes that erase what was drawn last
        self._preparing = Working(PREPARING)

    def __call__(self, done: int, total: int, note: str = "") -> None:
        now = time.monotonic()
        if self._first is None:
            self._first = done
            self._preparing.__exit__()
        if done < total and now - self._began > 0.5 and now - self._drawn > 0.1:
            self._drawn = now
            width = shutil.get_terminal_size().columns - 1
            bar = line(done, total, now - self._began, self._noun, self._first, width)
            rows = [bar, *wrapped(note, width)[:ROWS]]
            sys.stderr.write(self._erase + "\n".join(rows))
            sys.stderr.flush()
            self._erase = "\r" + f"\x1b[{len(rows) - 1}A" * (len(rows) > 1) + "\x1b[J"
        elif done == total:
            self._clear()

    def __enter__(self) -> "ProgressBar":
        self._preparing.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        self._preparing.__exit__()
        self._clear()

    def _clear(self) -> None:
        if self._drawn:
            self._drawn = 0.0
            sys.stderr.write(self._erase)
            sys.stderr.flush()


@contextmanager
def progress(quiet: bool, noun: str = "tick") -> Iterator[ProgressBar | None]:
    """Give a bar for `progress=...` that counts nouns; None if standard error is no terminal."""
    if quiet or not sys.stderr.isatty():
        yield None
    else:
        with ProgressBar(noun) as bar:
            yield bar


def line(done: int, total: int, seconds: float, noun: str = "tick", first: int = 0, width: int = 1000) -> str:
    """Return the bar as text of at most `width` characters; `first` were done before.

    >>> line(250_000, 1_000_000, 5.0)
    ' 25 % [######..................] 250,000 of 1,000,000 ticks, 20 us a tick, 15 s left'
    >>> line(250_000, 1_000_000, 5.0, width=59)
    ' 25 %, 250,000 of 1,000,000 ticks, 15 s left'
    """
    part, new = done / total, done - first
    pace = seconds / new if new else 0.0
    counted = f"{done:,} of {total:,} {noun}s"
    rate, left = (
        (f"{time_text(pace)} a {noun}", f"{time_text(pace * (total - done))} left") if new else ("", "starting")
    )
    bar = f"{100 * part:3.0f} % [{'#' * int(24 * part):.<24}] " + ", ".join(filter(None, (counted, rate, left)))
    return bar if len(bar) <= width else f"{100 * part:3.0f} %, {counted}, {left}"[:width]


def wrapped(note: str, width: int) -> list[str]:
    """Return entries that commas separate as rows of at most `width` characters.

    >>> wrapped("bias 1.5(2) V, noise 3.1(1) mV", 20)
    ['bias 1.5(2) V', 'noise 3.1(1) mV']
    """
    rows = [""]
    for entry in note.split(", ") if note else ():
        longer = f"{rows[-1]}, {entry}" if rows[-1] else entry
        rows[-1:] = [longer] if len(longer) <= width or not rows[-1] else [rows[-1], entry]
    return [row[:width] for row in rows if row]
