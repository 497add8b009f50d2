"""The covariance of a steady Kalman filter, by a structure-preserving doubling algorithm.

(Chu, Fan, Lin and Wang, Structure-preserving algorithms for periodic discrete-time algebraic
Riccati equations, International Journal of Control 77, 2004.) Each step does as much as all the
steps before: some ten are enough.
"""

from collections.abc import Sequence

from proofmass.blocks.arithmetic.modes import Matrix, product

STEPS = 60


def steady_gain(
    transition: Sequence[float], readout: Sequence[float], process: Sequence[float], noise: float
) -> list[float]:
    """K = P C' / (C P C' + R), one per state; the matrices A and Q are row after row.

    >>> steady_gain([1.0], [1.0], [2.0], 2.0)
    [0.6180339887498949]
    """
    order = len(readout)
    a, q = ([list(m[i : i + order]) for i in range(0, order * order, order)] for m in (transition, process))
    to_readout = [
        sum(v * c for v, c in zip(row, readout, strict=True)) for row in steady_covariance(a, readout, q, noise)
    ]
    variance = sum(v * c for v, c in zip(to_readout, readout, strict=True)) + noise
    return [v / variance for v in to_readout]


def steady_covariance(transition: Matrix, readout: Sequence[float], process: Matrix, noise: float) -> Matrix:
    """P of P = A P A' - A P C' (C P C' + R)^-1 C P A' + Q; numbers without end where C does not see what grows.

    >>> steady_covariance([[1.0]], [1.0], [[1.0]], 2.0)
    [[2.0]]
    """
    a = [list(row) for row in zip(*transition, strict=True)]
    g = [[left * right / noise for right in readout] for left in readout]
    h = process
    for _ in range(STEPS):
        w = product(g, h)
        for i in range(len(w)):
            w[i][i] += 1.0
        by_a, by_g = solved(w, a), solved(w, g)
        turned = [list(row) for row in zip(*a, strict=True)]
        following = _sum(h, product(product(turned, h), by_a))
        g = _sum(g, product(product(a, by_g), turned))
        a = product(a, by_a)
        if following == h:
            break
        h = following
    return h


def solved(matrix: Matrix, right: Matrix) -> Matrix:
    """matrix^-1 right, by elimination with the largest pivot.

    >>> solved([[0.0, 2.0], [4.0, 0.0]], [[2.0], [8.0]])
    [[2.0], [1.0]]
    """
    size = len(matrix)
    rows = [[*left, *more] for left, more in zip(matrix, right, strict=True)]
    for i in range(size):
        pivot = max(range(i, size), key=lambda k: abs(rows[k][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [value / rows[i][i] for value in rows[i]]
        for k in range(size):
            if k != i:
                rows[k] = [value - rows[k][i] * above for value, above in zip(rows[k], rows[i], strict=True)]
    return [row[size:] for row in rows]


def _sum(left: Matrix, right: Matrix) -> Matrix:
    return [[a + b for a, b in zip(first, second, strict=True)] for first, second in zip(left, right, strict=True)]
