"""Modes of M x'' + C x' + K x = B F, and their exact step under forces that are held over it.

Modes follow from the symmetric eigenproblem of L^-1 K L^-T, M = L L^T, by cyclic Jacobi rotations
(Golub and Van Loan, Matrix Computations, section 8.5); the step is a matrix exponential by scaling
and squaring of its series.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from proofmass.blocks.arithmetic.logarithms import binary_logarithm
from proofmass.blocks.arithmetic.rounding import nearest_integer
from proofmass.blocks.arithmetic.scaling import power_of_two

Matrix = list[list[float]]
LARGEST = 64  # rows
SWEEPS, TERMS = 60, 18  # rotations settle within ten sweeps; 0.5^18 / 18! is below 1e-21


class Modes(NamedTuple):
    """The lowest modes, scaled to a modal mass of 1."""

    rates: list[float]  # angular frequencies in rad/s, ascending
    shapes: Matrix  # one column per mode
    damping: Matrix  # shapes^T C shapes, in 1/s


def rows(values: Sequence[float], columns: int) -> Matrix:
    """Rows of a matrix that is written row after row."""
    return [list(values[i : i + columns]) for i in range(0, len(values), columns)]


def size_of(square: Sequence[float]) -> int:
    """Rows of a square matrix that is written row after row; 0 where it is not square, or has more than 64.

    >>> size_of([1.0, 0.0, 0.0, 1.0]), size_of([1.0, 0.0])
    (2, 0)
    """
    size = round(math.sqrt(float(len(square))))
    return size if size * size == len(square) and size <= LARGEST else 0


def is_positive_definite(matrix: Matrix) -> bool:
    """Return whether a matrix is symmetric, within 1e-9 of the largest, and positive definite."""
    level = max(abs(v) for row in matrix for v in row)
    even = all(abs(matrix[i][j] - matrix[j][i]) <= 1e-9 * level for i in range(len(matrix)) for j in range(i))
    return even and cholesky(matrix) is not None


def product(left: Matrix, right: Matrix) -> Matrix:
    """left right."""
    columns = list(zip(*right, strict=True))
    return [[sum(a * b for a, b in zip(row, column, strict=True)) for column in columns] for row in left]


def turned(matrix: Matrix) -> Matrix:
    """The transpose."""
    return [list(column) for column in zip(*matrix, strict=True)]


def cholesky(matrix: Matrix) -> Matrix | None:
    """L of a symmetric matrix L L^T; None where it is not positive definite.

    >>> cholesky([[4.0, 2.0], [2.0, 5.0]])
    [[2.0, 0.0], [1.0, 2.0]]
    """
    size = len(matrix)
    low = [[0.0] * size for _ in range(size)]
    for i in range(size):
        for j in range(i + 1):
            rest = matrix[i][j] - sum(low[i][k] * low[j][k] for k in range(j))
            if i == j and not rest > 1e-14 * abs(matrix[i][i]):
                return None
            low[i][j] = math.sqrt(rest) if i == j else rest / low[j][j]
    return low


def forward(low: Matrix, right: Matrix) -> Matrix:
    """low^-1 right of a lower triangle."""
    solved: Matrix = []
    for i, row in enumerate(low):
        solved.append([(v - sum(row[k] * solved[k][j] for k in range(i))) / row[i] for j, v in enumerate(right[i])])
    return solved


def eigen(matrix: Matrix) -> tuple[list[float], Matrix]:
    """Eigenvalues of a symmetric matrix, ascending, and one eigenvector in each column.

    >>> eigen([[2.0, 0.0], [0.0, 1.0]])
    ([1.0, 2.0], [[0.0, 1.0], [1.0, 0.0]])
    """
    size = len(matrix)
    a = [list(row) for row in matrix]
    v = [[1.0 if i == j else 0.0 for j in range(size)] for i in range(size)]  # an eigenvector each
    for _ in range(SWEEPS):
        turns = [_rotated(a, v, i, j) for i in range(size) for j in range(i + 1, size)]
        if not any(turns):
            break
    order = sorted(range(size), key=lambda i: a[i][i])
    return [a[i][i] for i in order], turned([v[i] for i in order])


def _rotated(a: Matrix, v: Matrix, p: int, q: int) -> bool:
    """Rotate the element (p, q) to zero; False where it is already too small to count."""
    if abs(a[p][q]) <= 1e-17 * math.sqrt(abs(a[p][p] * a[q][q])):
        return False
    half = 0.5 * (a[q][q] - a[p][p]) / a[p][q]
    root = math.sqrt(1.0 + half * half)
    t = 1.0 / (half + root if half >= 0.0 else half - root)  # abs has no slope at zero
    c = 1.0 / math.sqrt(1.0 + t * t)
    s = t * c
    moved = t * a[p][q]
    for k in range(len(a)):
        if k not in (p, q):
            first, second = a[p][k], a[q][k]
            a[p][k] = a[k][p] = c * first - s * second
            a[q][k] = a[k][q] = s * first + c * second
    a[p][p], a[q][q] = a[p][p] - moved, a[q][q] + moved
    a[p][q] = a[q][p] = 0.0
    first_row, second_row = v[p], v[q]
    v[p] = [c * x - s * y for x, y in zip(first_row, second_row, strict=True)]
    v[q] = [s * x + c * y for x, y in zip(first_row, second_row, strict=True)]
    return True


def lowest_modes(mass: Matrix, damping: Matrix, stiffness: Matrix, count: int) -> Modes:
    """The lowest modes of a structure with symmetric, positive definite mass and stiffness."""
    low = cholesky(mass)
    assert low is not None
    halfway = forward(low, stiffness)
    squares, vectors = eigen(turned(forward(low, turned(halfway))))
    upper = turned(low)
    size = len(low)
    shapes = [[0.0] * count for _ in range(size)]
    for i in reversed(range(size)):
        for m in range(count):
            above = sum(upper[i][k] * shapes[k][m] for k in range(i + 1, size))
            shapes[i][m] = (vectors[i][m] - above) / upper[i][i]
    shapes = turned([_upward(shape) for shape in turned(shapes)])
    modal = product(turned(shapes), product(damping, shapes))
    return Modes([math.sqrt(square) for square in squares[:count]], shapes, modal)


def _upward(shape: list[float]) -> list[float]:
    """The shape with the sign that makes its first large entry positive: another structure nearby has the same."""
    large = 0.5 * max(abs(v) for v in shape)
    first = next(v for v in shape if abs(v) >= large)
    return shape if first > 0.0 else [-v for v in shape]


def exponential_of(matrix: Matrix) -> Matrix:
    """e to the power of a matrix."""
    size = len(matrix)
    largest = max(sum(abs(v) for v in row) for row in matrix)
    squarings = 0
    while largest > 0.5 and squarings < 60:
        largest, squarings = 0.5 * largest, squarings + 1
    part = [[v / float(1 << squarings) for v in row] for row in matrix]
    total = [[1.0 if i == j else 0.0 for j in range(size)] for i in range(size)]
    for n in reversed(range(1, TERMS + 1)):  # Horner's rule
        total = [
            [v / float(n) + (1.0 if i == j else 0.0) for j, v in enumerate(row)]
            for i, row in enumerate(product(part, total))
        ]
    for _ in range(squarings):
        total = product(total, total)
    return total


def balanced_exponential(matrix: Matrix) -> Matrix:
    """e to the power of a matrix whose states have units far apart, such as displacements and velocities.

    Rows and columns are scaled by powers of 2 until they are alike (Parlett and Reinsch, Numer.
    Mathematik 13, 1969).
    """
    size = len(matrix)
    a, scales = [list(row) for row in matrix], [1.0] * size
    for _ in range(20):
        for i in range(size):
            column = sum(abs(a[j][i]) for j in range(size) if j != i)
            row = sum(abs(a[i][j]) for j in range(size) if j != i)
            if column == 0.0 or row == 0.0:
                continue
            factor = power_of_two(nearest_integer(0.5 * binary_logarithm(row / column)))
            scales[i] = scales[i] * factor
            for j in range(size):
                a[j][i] = a[j][i] * factor
                a[i][j] = a[i][j] / factor
    whole = exponential_of(a)
    return [[v * scales[i] / scales[j] for j, v in enumerate(row)] for i, row in enumerate(whole)]


def modal_step(modes: Modes, entry: Matrix, period: float) -> Matrix:
    """[A B] of z[n+1] = A z[n] + B F[n], z the modal displacements times their rates, then the modal velocities."""
    count, ports = len(modes.rates), len(entry[0])
    forces = product(turned(modes.shapes), entry)
    matrix = [[0.0] * (2 * count + ports) for _ in range(2 * count + ports)]
    for i, rate in enumerate(modes.rates):
        matrix[i][count + i], matrix[count + i][i] = rate * period, -rate * period
        for j in range(count):
            matrix[count + i][count + j] = -modes.damping[i][j] * period
        for j in range(ports):
            matrix[count + i][2 * count + j] = forces[i][j] * period
    return exponential_of(matrix)[: 2 * count]
