"""Type of the reports of progress of long work."""

from collections.abc import Callable

Progress = Callable[[int, int], None]  # what is done, and of how much in all
