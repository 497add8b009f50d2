"""Processes that are forked from this one and call one function of it: only its arguments and answers travel.

What the function reads need not be written or planned anew. A process ends with this one, whatever
ends that.
"""

import multiprocessing
import os
import signal
import warnings
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any


@dataclass(frozen=True)
class ForkedAnswer:
    """Outcome of a call: an answer, or none if it raised an exception or its process died."""

    place: Any  # of the call, as it was begun
    value: Any = None
    died: bool = False


class Forked:
    """Processes that call a function, as many as can be started."""

    def __init__(self, function: Callable[..., Any], count: int) -> None:
        self._processes: dict[Connection, BaseProcess] = {}
        self._busy: dict[Connection, Any] = {}
        self.died = 0
        if not can_fork():
            return
        context = multiprocessing.get_context("fork")
        for _ in range(count):
            here, there = context.Pipe()
            others = (here, *self._processes)
            process = context.Process(target=_answer_calls, args=(function, there, others), daemon=True)
            try:
                with warnings.catch_warnings():  # of other threads: what a call needs is not theirs
                    warnings.simplefilter("ignore", DeprecationWarning)
                    process.start()
            except OSError:  # there are as many as may be
                here.close()
                break
            finally:
                there.close()
            self._processes[here] = process

    @property
    def count(self) -> int:
        """Number of processes."""
        return len(self._processes)

    @property
    def idle(self) -> int:
        """Number of processes that wait for a call."""
        return len(self._processes) - len(self._busy)

    def begin(self, place: Any, arguments: Sequence[Any]) -> None:
        """Begin a call in a process that is idle; its answer has the same place."""
        connection = next(one for one in self._processes if one not in self._busy)
        self._busy[connection] = place
        with suppress(OSError):  # it died: so will its answer say
            connection.send(arguments)

    def arrived(self, seconds: float) -> list[ForkedAnswer]:
        """Return the answers that arrive within some seconds, at once when there is one."""
        return [self._received(one) for one in wait(list(self._busy), seconds) if isinstance(one, Connection)]

    def _received(self, connection: Connection) -> ForkedAnswer:
        place = self._busy.pop(connection)
        try:
            return ForkedAnswer(place, connection.recv())
        except (EOFError, OSError):
            self.died += 1
            self._ended(connection)
            return ForkedAnswer(place, died=True)

    def _ended(self, connection: Connection) -> None:
        process = self._processes.pop(connection)
        process.kill()
        process.join()
        connection.close()

    def close(self) -> None:
        """End all processes, whatever they do."""
        for connection in list(self._processes):
            self._ended(connection)


def can_fork() -> bool:
    """Return whether this process may have others: where there is no fork, and in a process of a pool, it may not."""
    return hasattr(os, "fork") and not multiprocessing.current_process().daemon


def _answer_calls(function: Callable[..., Any], connection: Connection, others: Sequence[Connection]) -> None:
    """Answer calls until whoever asks is gone; Ctrl-C is for that one alone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    for end in others:
        end.close()
    with suppress(EOFError, OSError):
        while True:
            arguments = connection.recv()
            try:
                value = function(*arguments)
            except Exception:  # whoever asks meets the same, in its turn
                value = None
            connection.send(value)
