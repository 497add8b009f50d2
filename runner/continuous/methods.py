"""One step of an explicit Runge-Kutta method, written once: on numbers in plain Python, on text for
the compiled loop.

    k_i = f(t + c_i h, x + h sum_j a_ij k_j),   x(t + h) = x + h sum_i b_i k_i

Runge-Kutta 4 is the classical method of order 4 (Hairer, Nørsett, Wanner, Solving Ordinary
Differential Equations I, 1993, table II.1.2); Dormand-Prince 5(4) has order 5 and an estimate of
its error (table II.5.2).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

Rates = Callable[[Any, list[Any]], list[Any]]  # of time and states


@dataclass(frozen=True)
class Explicit:
    """The coefficients of a method; `differences` are those of its error estimate, less its own."""

    order: int
    nodes: tuple[float, ...]
    stages: tuple[tuple[float, ...], ...]
    weights: tuple[float, ...]
    differences: tuple[float, ...] = ()


RUNGE_KUTTA_4 = Explicit(
    order=4,
    nodes=(0.0, 0.5, 0.5, 1.0),
    stages=((), (0.5,), (0.0, 0.5), (0.0, 0.0, 1.0)),
    weights=(1 / 6, 1 / 3, 1 / 3, 1 / 6),
)
_FIFTH = (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84, 0.0)
_FOURTH = (5179 / 57600, 0.0, 7571 / 16695, 393 / 640, -92097 / 339200, 187 / 2100, 1 / 40)
DORMAND_PRINCE = Explicit(
    order=5,
    nodes=(0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0),
    stages=(
        (),
        (1 / 5,),
        (3 / 40, 9 / 40),
        (44 / 45, -56 / 15, 32 / 9),
        (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
        (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
        _FIFTH[:6],
    ),
    weights=_FIFTH,
    differences=tuple(b - e for b, e in zip(_FIFTH, _FOURTH, strict=True)),
)
EXPLICIT = {"runge_kutta_4": RUNGE_KUTTA_4, "dormand_prince": DORMAND_PRINCE}


def explicit_step(method: Explicit, rates: Rates, time: Any, length: Any, x: Sequence[Any]) -> tuple[list[Any], ...]:
    """States after a step of that length, and the error estimate of a method that has one."""
    slopes: list[list[Any]] = []
    for node, row in zip(method.nodes, method.stages, strict=True):
        there = _moved(x, length, row, slopes) if any(row) else list(x)
        slopes.append(rates(time + node * length if node else time, there))
    moved = _moved(x, length, method.weights, slopes)
    if not method.differences:
        return (moved,)
    return moved, [length * s for s in _combined(method.differences, slopes)]


def _moved(x: Sequence[Any], length: Any, factors: Sequence[float], slopes: Sequence[Sequence[Any]]) -> list[Any]:
    """States after a step of that length along a sum of slopes.

    One factor that is a power of two is taken into the length: a product less for each state, and
    the same bits.
    """
    last = factors[-1]
    if not any(factors[:-1]) and math.frexp(last)[0] == 0.5:
        way = length * last
        return [v + way * s for v, s in zip(x, slopes[len(factors) - 1], strict=True)]
    return [v + length * s for v, s in zip(x, _combined(factors, slopes), strict=True)]


def _combined(factors: Sequence[float], slopes: Sequence[Sequence[Any]]) -> list[Any]:
    """Sum of slopes times factors, for each state, from left to right."""
    terms = [(factor, slope) for factor, slope in zip(factors, slopes, strict=False) if factor]
    totals = [terms[0][0] * s for s in terms[0][1]]
    for factor, slope in terms[1:]:
        totals = [total + factor * s for total, s in zip(totals, slope, strict=True)]
    return totals
