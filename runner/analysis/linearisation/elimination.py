"""The quotient of a sparse loop, exactly, by taking out one state after the other.

With q = 1 / z each state is x = q (A x + b u), an edge of a graph for each number (Mason,
Proceedings of the IRE 44, 1956, 920). A state that acts on itself through others alone is replaced
by what acts on it, which leaves polynomials in q on the edges. So a delay of a thousand samples is
one edge q^1000, and a filter of as many taps one polynomial. What is left is a small matrix I -
W(q). Its determinant, and that with b and c at its sides, are D and N, by Bareiss' elimination
without fractions (Mathematics of Computation 22, 1968, 565). Its pivots are 1 at q = 0, so none
vanishes.
"""

from collections.abc import Sequence
from typing import Any

import flint
import numpy as np

from proofmass.runner.host.arrays import Array

Edges = list[dict[int, Any]]  # of each node: polynomials in q by the node that acts on it
LARGEST_CORE = 24  # states that are left, of which determinants are taken


def eliminated(a: Array, b: Array, c: Array, d: float) -> tuple[Any, Any] | None:
    """Return N and D in q of a single input and output; None where too many states are left."""
    n = len(a)
    edges = _edges(a, b, c, d)
    left = _reduced(edges, n)
    if len(left) > LARGEST_CORE:
        return None
    return _determinants(edges, [*left], n)


def _edges(a: Array, b: Array, c: Array, d: float) -> Edges:
    """Return what acts on each state and, as node n, on the output; n is the input there."""
    n, later = len(a), flint.fmpq_poly([0, 1])
    edges: Edges = [{int(j): fraction(a[i, j]) * later for j in np.flatnonzero(a[i])} for i in range(n)]
    for i in np.flatnonzero(b).tolist():
        edges[i][n] = fraction(b[i]) * later
    edges.append({int(j): flint.fmpq_poly([fraction(c[j])]) for j in np.flatnonzero(c)})
    if d:
        edges[n][n] = flint.fmpq_poly([fraction(d)])
    return edges


def fraction(value: float) -> Any:
    """Return what a double is, to all bits."""
    return flint.fmpq(*float(value).as_integer_ratio())


def _reduced(edges: Edges, n: int) -> list[int]:
    """Take out the states that do not act on themselves and have one cause or one effect; return the others."""
    readers: list[set[int]] = [set() for _ in range(n + 1)]
    for i, row in enumerate(edges):
        for j in row:
            readers[j].add(i)
    waiting, left = list(range(n - 1, -1, -1)), set(range(n))
    while waiting:
        state = waiting.pop()
        if state not in left or state in edges[state] or min(len(edges[state]), len(readers[state])) > 1:
            continue
        left.discard(state)
        causes, edges[state] = edges[state], {}
        for cause in causes:
            readers[cause].discard(state)
        for reader in readers[state]:
            passed = edges[reader].pop(state)
            for cause, weight in causes.items():
                edges[reader][cause] = edges[reader].get(cause, 0) + passed * weight
                readers[cause].add(reader)
        waiting += [near for near in (*readers[state], *causes) if near in left]
        readers[state] = set()
    return sorted(left)


def _determinants(edges: Edges, left: Sequence[int], n: int) -> tuple[Any, Any]:
    """Return the determinants of [[I - W, b], [-c, d]] and of I - W."""
    places = {state: i for i, state in enumerate([*left, n])}
    m = len(left)
    matrix = [[flint.fmpq_poly([int(i == j < m)]) for j in range(m + 1)] for i in range(m + 1)]
    for i, state in enumerate([*left, n]):
        for cause, weight in edges[state].items():
            matrix[i][places[cause]] += weight if cause == n else -weight
    before = flint.fmpq_poly([1])
    for k in range(m):
        pivot = matrix[k][k]
        for row in matrix[k + 1 :]:
            for j in range(k + 1, m + 1):
                row[j] = (pivot * row[j] - row[k] * matrix[k][j]) // before
        before = pivot
    return matrix[m][m], before
