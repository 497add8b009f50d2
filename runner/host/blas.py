"""Threads of BLAS, the library of matrices: small ones wait for each other if there are several."""

from functools import cache
from typing import Any

from threadpoolctl import ThreadpoolController


def one_thread() -> Any:
    """Return a context in which BLAS has one thread."""
    return _libraries().limit(limits=1, user_api="blas")


@cache
def _libraries() -> ThreadpoolController:
    """Return the libraries that are loaded, which takes as long as a small proof."""
    return ThreadpoolController()
