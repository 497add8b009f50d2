"""Algebraic loops in dual numbers: the solution that Newton's method finds, with its exact derivatives.

    u = g(u, p):   u <- u + (I - J)^-1 (g(u, p) - u),   J = dg/du at the solution

The implicit function theorem, as a chord iteration in dual numbers: from plain values each step makes one more order of
the derivatives by p exact (Griewank and Walther 2008, section 15.3).
"""

from collections.abc import Callable, Sequence
from typing import Any

from proofmass.runner.continuous.algebraic import solve_in_place
from proofmass.runner.continuous.linear_equations import factorise, substitute
from proofmass.runner.derivatives.dual import SIGNALS, dual, plain, slopes_of

_ORDERS = 2  # signals, and parameters of their slopes


def solve_dual(tears: Sequence[Any], others: Sequence[Any], signals: Any, value: Callable[[Any], Any]) -> bool:
    """Solve a loop as `algebraic.solve_in_place` does; `value(node)` and the solution may be dual numbers."""
    for tear in tears:
        signals[tear] = plain(signals[tear])
    if not solve_in_place(tears, others, signals, lambda node: plain(value(node))):
        return False

    def equations(unknown: list[Any]) -> list[Any]:
        for tear, held in zip(tears, unknown, strict=True):
            signals[tear] = held
        for node in others:
            signals[node] = value(node)
        return [value(tear) for tear in tears]

    solution: list[Any] = [signals[tear] for tear in tears]
    directions = [("tear", number) for number in range(len(tears))]
    moved = equations([dual(v, {key: 1.0}, SIGNALS) for v, key in zip(solution, directions, strict=True)])
    jacobian = [[plain(slopes_of(v, SIGNALS).get(key, 0.0)) for key in directions] for v in moved]
    inverse = _inverse([[float(i == j) - v for j, v in enumerate(row)] for i, row in enumerate(jacobian)])
    if inverse is None:
        return False
    for _ in range(_ORDERS):
        apart = [there - here for there, here in zip(equations(solution), solution, strict=True)]
        solution = [
            sum((factor * d for factor, d in zip(row, apart, strict=True)), here)
            for row, here in zip(inverse, solution, strict=True)
        ]
    equations(solution)
    return True


def _inverse(rows: list[list[float]]) -> list[list[float]] | None:
    """The inverse of a matrix, None where there is none."""
    n = len(rows)
    matrix, order = [v for row in rows for v in row], [0.0] * n
    if not factorise(matrix, n, order):
        return None
    columns = [[float(i == j) for i in range(n)] for j in range(n)]
    for column in columns:
        substitute(matrix, n, order, column)
    return [list(row) for row in zip(*columns, strict=True)]
