"""A progress bar on a terminal; nothing where nobody looks."""

import shutil
import sys
import time


class ProgressBar:
    """Draws how much is done, with rate and time left, on standard error; used with `with`, it cleans up."""

    def __init__(self, noun: str) -> None:
        self._noun = noun
        self._first: int | None = None  # done before, in an earlier start
        self._began = time.monotonic()
        self._drawn = 0.0

    def __call__(self, done: int, total: int, note: str = "") -> None:
        now = time.monotonic()
        if self._first is None:
            self._first = done
        if done < total and now - self._began > 0.5 and now - self._drawn > 0.1:
            self._drawn = now
            width = shutil.get_terminal_size().columns - 1
            sys.stderr.write(f"\r\x1b[K{line(done, total, now - self._began, self._noun, self._first, note)[:width]}")
            sys.stderr.flush()
        elif done == total:
            self._clear()

    def __enter__(self) -> "ProgressBar":
        return self

    def __exit__(self, *error: object) -> None:
        self._clear()

    def _clear(self) -> None:
        if self._drawn:
            self._drawn = 0.0
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()


def progress_bar(quiet: bool, noun: str = "tick") -> ProgressBar | None:
    """A bar for `progress=...`, which counts nouns; None where standard error is no terminal."""
    return None if quiet or not sys.stderr.isatty() else ProgressBar(noun)


def line(done: int, total: int, seconds: float, noun: str = "tick", first: int = 0, note: str = "") -> str:
    """The bar as text; `first` were done before the seconds began, a note stands at the end.

    >>> line(250_000, 1_000_000, 5.0)
    ' 25 % [######..................] 250,000 of 1,000,000 ticks, 20 us a tick, 15 s left'
    """
    part = done / total
    bar = "#" * int(24 * part)
    new = done - first
    rate = (
        f"{time_text(seconds / new)} a {noun}, {time_text(seconds / new * (total - done))} left" if new else "starting"
    )
    return f"{100 * part:3.0f} % [{bar:.<24}] {done:,} of {total:,} {noun}s, {rate}" + (f", {note}" if note else "")


def time_text(seconds: float) -> str:
    """A time with a unit that suits it."""
    for unit, size in (("h", 3600.0), ("min", 60.0), ("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"
