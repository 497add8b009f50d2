"""Linear equations by Gaussian elimination.

Plain Python runs these functions on lists, the compiled loop on arrays, both to the same bits.
"""

from typing import Any

Flat = Any  # a sequence of floats: a list, or an array in the compiled loop


def factorise(matrix: Flat, n: int, order: Flat) -> bool:
    """Gaussian elimination in place; false where the matrix is singular.

    The pivot is the largest entry relative to its row, since rows differ by their units; `order`
    keeps the exchanges.
    """
    for k in range(n):
        best, chosen = 0.0, k
        for i in range(k, n):
            size = 0.0
            for j in range(k, n):
                size = max(size, abs(matrix[i * n + j]))
            if abs(matrix[i * n + k]) > best * size:
                best, chosen = abs(matrix[i * n + k]) / size, i
        if not best > 0.0:
            return False
        order[k] = chosen
        for j in range(n):
            matrix[k * n + j], matrix[chosen * n + j] = matrix[chosen * n + j], matrix[k * n + j]
        for i in range(k + 1, n):
            factor = matrix[i * n + k] / matrix[k * n + k]
            matrix[i * n + k] = factor
            for j in range(k + 1, n):
                matrix[i * n + j] -= factor * matrix[k * n + j]
    return True


def substitute(matrix: Flat, n: int, order: Flat, right: Flat) -> None:
    """The solution of factorised equations, in place of their right-hand side."""
    for k in range(n):
        chosen = int(order[k])
        right[k], right[chosen] = right[chosen], right[k]
    for i in range(n):
        for j in range(i):
            right[i] -= matrix[i * n + j] * right[j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            right[i] -= matrix[i * n + j] * right[j]
        right[i] /= matrix[i * n + i]
