"""A progress bar on a terminal; nothing where nobody looks."""

import sys
import time
from collections.abc import Callable


def progress_bar(quiet: bool) -> Callable[[int, int], None] | None:
    """A function that draws how many ticks are done, with rate and time left; None where standard error is no terminal."""
    if quiet or not sys.stderr.isatty():
        return None
    began = time.monotonic()
    drawn = 0.0

    def draw(done: int, total: int) -> None:
        nonlocal drawn
        now = time.monotonic()
        if done == total:
            sys.stderr.write("\r\x1b[K" if drawn else "")
        elif now - began > 0.5 and now - drawn > 0.1:
            drawn = now
            sys.stderr.write(f"\r\x1b[K{line(done, total, now - began)}")
        sys.stderr.flush()

    return draw


def line(done: int, total: int, seconds: float) -> str:
    """The bar as text.

    >>> line(250_000, 1_000_000, 5.0)
    ' 25 % [######..................] 250,000 of 1,000,000 ticks, 20 us a tick, 15 s left'
    """
    part = done / total
    bar = "#" * int(24 * part)
    rate = f"{time_text(seconds / done)} a tick, {time_text(seconds * (1 - part) / part)} left" if done else "starting"
    return f"{100 * part:3.0f} % [{bar:.<24}] {done:,} of {total:,} ticks, {rate}"


def time_text(seconds: float) -> str:
    """A time with a unit that suits it."""
    for unit, size in (("h", 3600.0), ("min", 60.0), ("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"
