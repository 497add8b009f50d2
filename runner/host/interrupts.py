"""Ctrl-C and SIGTERM as a flag that a loop looks at between chunks, instead of an exception in the midst of one."""

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

STUCK_SECONDS = 1.0  # from a first Ctrl-C to one that is not patient


class StoppedError(RuntimeError):
    """Runs that were interrupted before their end."""


@contextmanager
def interrupts() -> Iterator[threading.Event]:
    """An event that Ctrl-C and SIGTERM set instead of breaking into a chunk; a chunk that is stuck is broken into."""
    pressed = threading.Event()
    times = []

    def note(number: int, frame: FrameType | None) -> None:
        pressed.set()
        times.append(time.monotonic())
        if times[-1] - times[0] > STUCK_SECONDS:
            raise KeyboardInterrupt

    handlers: dict[signal.Signals, Any] = {}
    if threading.current_thread() is threading.main_thread():
        handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    for number, before in handlers.items():
        if before not in (signal.SIG_IGN, None):
            signal.signal(number, note)
    try:
        yield pressed
    finally:
        for number, before in handlers.items():
            if before not in (signal.SIG_IGN, None):
                signal.signal(number, before)
