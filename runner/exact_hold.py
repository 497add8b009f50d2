"""Exact sampled form of linear continuous systems whose inputs are held over the step.

    x' = A x + B u,  u constant over T:   x[n+1] = exp(A T) x[n] + (integral of exp(A t) dt over T) B u[n]

Both matrices are read off the exponential of [[A, B], [0, 0]] T, by Taylor series with scaling and squaring after
balancing by powers of two (states of a sensor differ by many orders of magnitude).
"""

import math

Matrix = list[list[float]]

_TERMS = 22  # 1/22! is below the rounding error for a norm of at most 1


def hold(a: Matrix, b: Matrix, period: float) -> tuple[Matrix, Matrix]:
    """Transition and input matrix of one step of `period` seconds, by rows."""
    n, m = len(a), len(b[0]) if b else 0
    joined = [[*(v * period for v in a[i]), *(v * period for v in b[i])] for i in range(n)]
    joined += [[0.0] * (n + m) for _ in range(m)]
    result = matrix_exponential(joined)
    return [row[:n] for row in result[:n]], [row[n:] for row in result[:n]]


def matrix_exponential(matrix: Matrix) -> Matrix:
    """exp of a square matrix."""
    size = len(matrix)
    balanced, scale = _balance(matrix)
    norm = max((sum(abs(v) for v in row) for row in balanced), default=0.0)
    halvings = max(0, math.frexp(norm)[1]) if norm > 0.0 else 0
    small = [[math.ldexp(v, -halvings) for v in row] for row in balanced]
    # exp - 1 is carried through the squarings, (1 + E)^2 - 1 = 2 E + E^2, so that small entries keep their digits.
    grown = [row[:] for row in small]
    for term in range(_TERMS, 1, -1):
        grown = _product(small, grown, 1.0 / term)
        for i in range(size):
            for j in range(size):
                grown[i][j] += small[i][j]
    for _ in range(halvings):
        square = _product(grown, grown, 1.0)
        grown = [[2.0 * grown[i][j] + square[i][j] for j in range(size)] for i in range(size)]
    for i in range(size):
        grown[i][i] += 1.0
    return [[grown[i][j] * scale[i] / scale[j] for j in range(size)] for i in range(size)]


def _product(left: Matrix, right: Matrix, factor: float) -> Matrix:
    columns = list(zip(*right, strict=True))
    return [[math.fsum(x * y for x, y in zip(row, column, strict=True)) * factor for column in columns] for row in left]


def _balance(matrix: Matrix) -> tuple[Matrix, list[float]]:
    """D^-1 M D with powers of two on D so that rows and columns are of like size (Parlett and Reinsch 1969)."""
    size = len(matrix)
    balanced = [row[:] for row in matrix]
    scale = [1.0] * size
    for _ in range(100):
        settled = True
        for i in range(size):
            row = sum(abs(balanced[i][j]) for j in range(size) if j != i)
            column = sum(abs(balanced[j][i]) for j in range(size) if j != i)
            if row == 0.0 or column == 0.0:
                continue
            shift = round(math.log2(row / column) / 2.0)
            if shift:
                settled = False
                scale[i] = math.ldexp(scale[i], shift)
                for j in range(size):
                    balanced[i][j] = math.ldexp(balanced[i][j], -shift)
                    balanced[j][i] = math.ldexp(balanced[j][i], shift)
        if settled:
            break
    return balanced, scale
