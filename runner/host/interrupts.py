"""Ctrl-C and SIGTERM as a flag a loop checks between chunks, instead of an exception within one."""

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

STUCK_SECONDS = 1.0  # after a first Ctrl-C, a further one breaks into the chunk


class StoppedError(RuntimeError):
    """Raised when runs were interrupted before their end."""


@contextmanager
def interrupts() -> Iterator[threading.Event]:
    """Give an event that Ctrl-C and SIGTERM set; a second one, after a second, breaks into a chunk that is stuck."""
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
