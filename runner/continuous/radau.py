"""Radau IIA of order 5, the implicit method for stiff groups (Hairer, Wanner, Solving Ordinary
Differential Equations II, 1996, section IV.8).

    z_i = h sum_j a_ij f(t + c_j h, x + z_j),  i = 1, 2, 3;   x(t + h) = x + z_3

solved by Newton's method with the derivatives of f by differences: they decide how fast it
converges, not where to. The error estimate is that of section IV.8, eq. 8.19: (g/h - J)^-1 (f(t,
x) + (e_1 z_1 + e_2 z_2 + e_3 z_3) / h).

Plain Python runs these functions on lists, the compiled loop on arrays, both to the same bits.
"""

import math
from typing import Any, NamedTuple

from proofmass.runner.continuous.linear_equations import Flat, factorise, substitute

ORDER = 4  # in the step, of the error estimate
_ROOT = math.sqrt(6.0)
C1, C2 = (4.0 - _ROOT) / 10.0, (4.0 + _ROOT) / 10.0
A11, A12, A13 = (88.0 - 7.0 * _ROOT) / 360.0, (296.0 - 169.0 * _ROOT) / 1800.0, (-2.0 + 3.0 * _ROOT) / 225.0
A21, A22, A23 = (296.0 + 169.0 * _ROOT) / 1800.0, (88.0 + 7.0 * _ROOT) / 360.0, (-2.0 - 3.0 * _ROOT) / 225.0
A31, A32, A33 = (16.0 - _ROOT) / 36.0, (16.0 + _ROOT) / 36.0, 1.0 / 9.0
G = 30.0 / (6.0 + 81.0 ** (1.0 / 3.0) - 9.0 ** (1.0 / 3.0))  # real eigenvalue of (a_ij)^-1
E1, E2, E3 = -(13.0 + 7.0 * _ROOT) / 3.0, (-13.0 + 7.0 * _ROOT) / 3.0, -1.0 / 3.0

ITERATIONS = 12
CONVERGED = 1e-12  # change of the stages, of the largest value that a state ever had
NUDGE = 1e-7  # for the derivatives, of that value


class _Step(NamedTuple):
    """A step of h seconds, as `radau_step` is given it."""

    rates: Any
    context: Any
    time: float
    h: float
    x: Flat
    moved: Flat
    largest: Flat


def scratch(n: int) -> tuple[int, ...]:
    """Return the lengths of the sequences that `radau_step` works on, for n states."""
    return (n, n, n * n, n * n, 9 * n * n, 3 * n, 3 * n, 3 * n)


def radau_step(
    rates: Any, context: Any, time: float, h: float, x: Flat, moved: Flat, error: Flat, largest: Flat, work: Any
) -> None:
    """States after a step of h seconds and their error: infinite where Newton's method does not converge.

    `rates(context, time, x, out)` writes the derivatives; `largest` is what each state ever was;
    `work` is scratch.
    """
    slope, there, jacobian, filtered, matrix, z, change, order = work
    step, n = _Step(rates, context, time, h, x, moved, largest), len(x)
    rates(context, time, x, slope)
    _differentiate(step, there, slope, change, jacobian)
    for row in range(3 * n):
        z[row] = 0.0
        for column in range(3 * n):
            matrix[row * 3 * n + column] = -h * _weight(row // n, column // n) * jacobian[row % n * n + column % n]
        matrix[row * 3 * n + row] += 1.0
    regular = factorise(matrix, 3 * n, order)
    settled = False
    for _ in range(ITERATIONS):
        if regular and not settled:
            settled = _iterate(step, there, z, change, matrix, order)
    for i in range(n):
        moved[i] = x[i] + z[2 * n + i]
        error[i] = slope[i] + (E1 * z[i] + E2 * z[n + i] + E3 * z[2 * n + i]) / h
        for j in range(n):
            filtered[i * n + j] = -jacobian[i * n + j]
        filtered[i * n + i] += G / h
    if regular and settled and factorise(filtered, n, order):
        substitute(filtered, n, order, error)
    else:
        for i in range(n):
            error[i] = math.inf


def _differentiate(step: _Step, there: Flat, slope: Flat, nudged: Flat, jacobian: Flat) -> None:
    """Derivatives of the rates; zero for a state that never moved and does not now."""
    x, n = step.x, len(step.x)
    for i in range(n):
        there[i] = x[i]
    for j in range(n):
        there[j] = x[j] + NUDGE * max(step.largest[j], abs(x[j]), abs(step.h * slope[j]))
        nudge = there[j] - x[j]
        step.rates(step.context, step.time, there, nudged)
        there[j] = x[j]
        for i in range(n):
            jacobian[i * n + j] = (nudged[i] - slope[i]) / nudge if nudge > 0.0 else 0.0


def _iterate(step: _Step, there: Flat, z: Flat, change: Flat, matrix: Flat, order: Flat) -> bool:
    """One step of Newton's method for the stages z; whether they have settled."""
    x, slope, n = step.x, step.moved, len(step.x)
    for row in range(3 * n):
        change[row] = -z[row]
    for stage in range(3):
        for i in range(n):
            there[i] = x[i] + z[stage * n + i]
        step.rates(step.context, step.time + _node(stage) * step.h, there, slope)
        for other in range(3):
            for i in range(n):
                change[other * n + i] += step.h * _weight(other, stage) * slope[i]
    substitute(matrix, 3 * n, order, change)
    settled = True
    for row in range(3 * n):
        z[row] += change[row]
        size = max(step.largest[row % n], abs(x[row % n]), abs(z[row]))
        settled = settled and abs(change[row]) <= CONVERGED * size
    return settled


def _node(stage: int) -> float:
    return C1 if stage == 0 else C2 if stage == 1 else 1.0


def _weight(row: int, column: int) -> float:
    if row == 0:
        return A11 if column == 0 else A12 if column == 1 else A13
    if row == 1:
        return A21 if column == 0 else A22 if column == 1 else A23
    return A31 if column == 0 else A32 if column == 1 else A33
