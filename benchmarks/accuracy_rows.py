"""Rows of the table of accuracies: the numbers of each kind of system, chosen ones and those drawn between them."""

import math
import random
from collections.abc import Callable, Iterator, Sequence
from functools import partial

from benchmarks.accuracy_systems import (
    System,
    alternating,
    clipped,
    diode,
    duffing,
    fringes,
    hardening,
    locked,
    plates,
    reaction,
    relay,
    softened,
    stops,
    thermostat,
    van_der_pol,
)

DUFFING = [
    (1e11, 1e-5, 900.0, 1e-4, 20e3),
    (1e12, 3e-5, 2e3, 1e-4, 20e3),
    (1e13, 1e-5, 4e3, 1e-5, 50e3),
    (1e12, 1e-5, 5e3, 1e-3, 5e3),
    (-1e11, 1e-5, 700.0, 1e-4, 10e3),
    (5e11, 1e-4, 1.5e3, 1e-3, 4e3),
    (1e10, 1e-4, 300.0, 3e-4, 2e3),
    (1e13, 3e-6, 5.1e3, 1e-5, 100e3),
]
STOPS = [
    (3e-5, 300.0, 0.5, 10e3),
    (5e-5, 500.0, 0.7, 20e3),
    (2e-5, 250.0, 0.3, 4e3),
    (4e-5, 400.0, 0.9, 2e3),
    (1e-4, 900.0, 0.6, 5e3),
]
LOCKED = [
    (8005.0, 8000.0, 10.0, 20.0, 1e3),
    (8000.0, 7990.0, 50.0, 100.0, 2e3),
    (20e3, 19.9e3, 300.0, 1e3, 20e3),
    (1000.0, 990.0, 30.0, 50.0, 10e3),
    (500.0, 505.0, 10.0, 20.0, 5e3),
]
KINDS: Sequence[tuple[Callable[..., System], Sequence[tuple[float, ...]]]] = [
    (duffing, DUFFING),
    (hardening, [(1e9,), (1e10,), (1e11,), (1e12,), (1e13,)]),
    (plates, [(0.5, 500, 10e3), (0.8, 1000, 10e3), (1.0, 3e3, 50e3), (0.6, 7e3, 2e3)]),
    (partial(plates, film=True), [(0.8, 500, 10e3), (1.0, 1000, 20e3), (1.2, 2e3, 2e3), (1.5, 300, 5e3)]),
    (softened, [(1.0, 10e3), (3.0, 50e3), (5.0, 5e3), (4.5, 1e3)]),
    (stops, STOPS),
    (locked, LOCKED),
    (relay, [(0.5, 16.0, 1e3), (0.1, 5.0, 1e3), (0.9, 50.0, 500), (0.3, 100.0, 100)]),
    (thermostat, [(1.0, 0.1, 10.0), (0.5, 0.05, 20.0), (1.5, 0.02, 5.0), (1.0, 0.3, 1.0)]),
    (fringes, [(1.0, 2e3, 10e3), (3.0, 5e3, 10e3), (0.5, 2e4, 2e3), (2.0, -3e3, 50e3)]),
    (clipped, [(10.0, 0.2, 20e3), (12.0, 0.5, 10e3), (20.0, 0.9, 5e3), (9.0, 0.3, 50e3)]),
    (diode, [(0.2, 500, 10e3), (0.5, 500, 10e3), (0.3, 2e3, 5e3), (1.0, 200, 20e3)]),
    (van_der_pol, [(5.0, 10.0, 12.0), (10.0, 10.0, 15.0), (30.0, 5.0, 20.0), (300.0, 1.0, 150.0)]),
    (reaction, [(3e5,), (3e6,), (3e7,)]),
    (alternating, [(0.3, 20e3), (0.3, 40e3), (0.2, 23_456.7), (0.1, 80e3)]),
]


def systems() -> list[System]:
    """All systems: those of rows, and three more of each kind that are drawn between them."""
    dice = random.Random(5)
    chosen = [made(*row) for made, rows in KINDS for row in rows]
    return chosen + [made(*_between(rows, dice)) for made, rows in KINDS for _ in range(3)]


def _between(rows: Sequence[tuple[float, ...]], dice: random.Random) -> Iterator[float]:
    """Yield numbers of two digits between the least and the largest of each column."""
    for column in zip(*rows, strict=True):
        least, most = min(column), max(column)
        by_size = least > 0.0
        drawn = dice.uniform(math.log(least), math.log(most)) if by_size else dice.uniform(least, most)
        yield float(f"{math.exp(drawn) if by_size else drawn:.2g}")
