"""How far a long piece of work has come."""

from collections.abc import Callable

Progress = Callable[[int, int], None]  # what is done, and of how much in all
