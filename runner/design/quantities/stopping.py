"""Progress of a search, and its end from within an optimiser when a person wishes it."""

import threading


class InterruptedSearch(Exception):  # noqa: N818  # ends a search from within SciPy
    """The search was to stop."""


def go_on(stop: threading.Event | None) -> None:
    """Raise `InterruptedSearch` if the search is to stop."""
    if stop is not None and stop.is_set():
        raise InterruptedSearch
