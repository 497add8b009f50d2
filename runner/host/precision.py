"""The precision of balls of python-flint, which all threads of a process share: one thread counts with them at a time.

Another precision than that of the thread gives other last digits, so that a study would not have
one digest. What waits here loses nothing: threads of Python count one at a time anyway.
"""

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import flint

import proofmass.runner.host.llvm_lock  # noqa: F401 - registered first: a fork takes its lock last

BITS = 512  # of inexact numbers; far beyond the cancellation in loops of some hundred states
_COUNTING = threading.RLock()
flint.ctx.prec = BITS  # what is looked at outside of a block has as many

if hasattr(os, "register_at_fork"):  # no child finds it held by a thread that it does not have
    os.register_at_fork(before=_COUNTING.acquire, after_in_parent=_COUNTING.release, after_in_child=_COUNTING.release)


@contextmanager
def precision(bits: int = BITS) -> Iterator[None]:
    """Count with balls of so many bits, also as a decorator of a function that does."""
    with _COUNTING, flint.ctx.workprec(bits):
        yield
