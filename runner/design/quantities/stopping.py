"""Progress of a search, and its end from within an optimiser when a person wishes it."""

import threading
from collections.abc import Callable

Progress = Callable[[int, int], None]  # evaluations done, and of about how many


class InterruptedSearch(Exception):  # noqa: N818  # ends a search from within SciPy
    """The search was to stop."""


def go_on(stop: threading.Event | None) -> None:
    """Raise `InterruptedSearch` if the search is to stop."""
    if stop is not None and stop.is_set():
        raise InterruptedSearch
