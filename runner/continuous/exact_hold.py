"""Exact sampled form of linear continuous systems whose inputs are held, or move on a straight
line, over the step.

    x' = A x + B u,  u constant over T:   x[n+1] = exp(A T) x[n] + (integral of exp(A t) dt over T) B u[n]

Both matrices are read off the exponential of [[A, B], [0, 0]] T, by Taylor series with scaling and
squaring after balancing by powers of two (states of a sensor differ by many orders of magnitude).
An input that moves linearly from u[n] to u[n+1] is one whose derivative is held: another row of the
same matrix.

The functions work in place on flat sequences, row by row, so that plain Python runs them on lists
and the compiled loop on arrays: to the same bits, in every tick where a driven parameter has moved.
"""

from collections.abc import Callable

from proofmass.blocks.arithmetic.modes import Matrix
from proofmass.runner.continuous.linear_equations import Flat

MatrixProduct = Callable[[Flat, Flat, int, Flat], None]

TERMS = 22  # 1/22! is below the rounding error for a norm of at most 1
LARGEST_SCALE = 2.0**300
MANY_COLUMNS = 24  # largest matrix whose products plain Python and programs write out; NumPy and loops take larger ones
UNIT = 2.0**200  # state or input in which rates have their slope to the last bit, beside any constant
SCRATCH = 3  # sequences as large as the matrix that `matrix_exponential` needs


def hold(a: Matrix, b: Matrix, period: float, ramps: tuple[int, ...] = ()) -> tuple[Matrix, Matrix]:
    """Transition and input matrix of one step of `period` seconds, by rows.

    `ramps` are the inputs (columns of b) that move linearly; the input matrix has a column more for
    each, of its change over the step.
    """
    n, m = len(a), len(b[0]) if b else 0
    size = n + m + len(ramps)
    flat = [0.0] * (size * size)
    for i in range(n):
        flat[i * size : i * size + n + m] = [*a[i], *b[i]]
    scale_rows(flat, n, n + m, size, period)
    for number, ramp in enumerate(ramps):
        flat[(n + ramp) * size + n + m + number] = 1.0
    grown, square, scale = ([0.0] * (size * size) for _ in range(SCRATCH))
    matrix_exponential(flat, size, grown, square, scale, multiply if size <= MANY_COLUMNS else multiply_arrays)
    rows = [flat[i * size : (i + 1) * size] for i in range(n)]
    return [row[:n] for row in rows], [row[n:] for row in rows]


def scale_rows(flat: Flat, rows: int, columns: int, size: int, factor: float) -> None:
    """Multiply the first entries of the first rows of a square matrix."""
    for i in range(rows):
        for j in range(columns):
            flat[i * size + j] *= factor


def sum_rows(matrix: Flat, terms: Flat, sums: Flat, rows: int, columns: int) -> None:
    """Each row of a matrix times some terms, summed from the first to the last."""
    for i in range(rows):
        total = matrix[i * columns] * terms[0]
        for j in range(1, columns):
            total += matrix[i * columns + j] * terms[j]
        sums[i] = total


def matrix_exponential(matrix: Flat, size: int, grown: Flat, square: Flat, scale: Flat, product: MatrixProduct) -> None:
    """exp of a square matrix, in place; the others are scratch. `product` is `multiply`, or what gives the same."""
    balance(matrix, size, scale)
    norm = 0.0
    for i in range(size):
        row = 0.0
        for j in range(size):
            row += abs(matrix[i * size + j])
        norm = max(norm, row)
    halvings, factor = 0, 1.0
    while norm * factor > 1.0 and halvings < 1000:
        halvings, factor = halvings + 1, 0.5 * factor
    for k in range(size * size):
        matrix[k] *= factor
        grown[k] = matrix[k]
    # exp - 1 is carried through the squarings, (1 + E)^2 - 1 = 2 E + E^2, so that small entries keep their digits.
    for term in range(TERMS, 1, -1):
        product(matrix, grown, size, square)
        for k in range(size * size):
            grown[k] = square[k] * (1.0 / term) + matrix[k]
    for _ in range(halvings):
        product(grown, grown, size, square)
        for k in range(size * size):
            grown[k] = 2.0 * grown[k] + square[k]
    for i in range(size):
        grown[i * size + i] += 1.0
        for j in range(size):
            matrix[i * size + j] = grown[i * size + j] * scale[i] / scale[j]


def multiply(left: Flat, right: Flat, size: int, product: Flat) -> None:
    """Product of two square matrices: each entry is summed from the first term to the last, without those of zeros."""
    for i in range(size):
        for j in range(size):
            product[i * size + j] = 0.0
        for k in range(size):
            entry = left[i * size + k]
            if entry != 0.0:
                for j in range(size):
                    product[i * size + j] += entry * right[k * size + j]


def multiply_arrays(left: Flat, right: Flat, size: int, product: Flat) -> None:
    """Multiply as `multiply` does, with the same sums in order, a whole term at a time."""
    # start-up time: only large groups need NumPy, and `check` plans without it
    import numpy as np

    a, b = (np.array(flat).reshape(size, size) for flat in (left, right))
    total = np.zeros((size, size))
    with np.errstate(over="ignore", invalid="ignore"):
        for k in range(size):
            rows = np.flatnonzero(a[:, k])
            total[rows] += a[rows, k, np.newaxis] * b[k]
    product[:] = total.ravel().tolist()


def balance(matrix: Flat, size: int, scale: Flat) -> None:
    """Make of M D^-1 M D, with powers of two on D: rows and columns are of like size (Parlett and Reinsch 1969)."""
    for i in range(size):
        scale[i] = 1.0
    for _ in range(100):
        settled = True
        for i in range(size):
            row, column = 0.0, 0.0
            for j in range(size):
                if j != i:
                    row += abs(matrix[i * size + j])
                    column += abs(matrix[j * size + i])
            if row == 0.0 or column == 0.0:
                continue
            factor = 1.0
            while 4.0 * column * factor < row / factor and factor < LARGEST_SCALE:
                factor *= 2.0
            while column * factor > 4.0 * row / factor and factor > 1.0 / LARGEST_SCALE:
                factor *= 0.5
            if factor != 1.0:
                settled = False
                scale[i] *= factor
                for j in range(size):
                    matrix[i * size + j] /= factor
                    matrix[j * size + i] *= factor
        if settled:
            return
