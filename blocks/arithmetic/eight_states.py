"""Eight states of a linear analog system: rows of matrices times states and four inputs."""

from collections.abc import Sequence
from typing import NamedTuple

Eight = tuple[float, float, float, float, float, float, float, float]
Four = tuple[float, float, float, float]


class State(NamedTuple):
    x1: float
    x2: float
    x3: float
    x4: float
    x5: float
    x6: float
    x7: float
    x8: float


def padded(row: Sequence[float]) -> Eight:
    """The row with zeros behind."""
    r = [*row, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    return r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7]


def along(row: Eight, x: State) -> float:
    """A row times the states."""
    low = (row[0] * x.x1 + row[1] * x.x2) + (row[2] * x.x3 + row[3] * x.x4)
    return low + ((row[4] * x.x5 + row[5] * x.x6) + (row[6] * x.x7 + row[7] * x.x8))


def moved(a: Eight, b: Four, x: State, first: float, second: float, third: float, fourth: float) -> float:
    """Rate of change of one state."""
    return along(a, x) + ((b[0] * first + b[1] * second) + (b[2] * third + b[3] * fourth))
