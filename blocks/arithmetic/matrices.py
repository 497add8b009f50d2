"""Products of matrices and vectors in the loop; a matrix is a list of numbers, row after row."""

from collections.abc import Iterator, Sequence


def combined(a: list[float], x: list[float], b: list[float], u: list[float], out: list[float]) -> None:
    """Write A x + B u into `out`; each sum goes from left to right.

    >>> out = [0.0, 0.0]
    >>> combined([1.0, 2.0, 3.0, 4.0], [1.0, 1.0], [10.0, 20.0], [0.5], out)
    >>> out
    [8.0, 17.0]
    """
    n, m = len(x), len(u)
    for i in range(len(out)):
        total = 0.0
        for j in range(n):
            total += a[i * n + j] * x[j]
        for j in range(m):
            total += b[i * m + j] * u[j]
        out[i] = total


def product_with_part(a: list[float], x: list[float], first: int, count: int, out: list[float]) -> None:
    """Write A times `count` entries of x, from the first on, into `out`."""
    for i in range(len(out)):
        total = 0.0
        for j in range(count):
            total += a[i * count + j] * x[first + j]
        out[i] = total


def stepped(a: list[float], x: list[float], b: list[float], u: list[float], following: list[float]) -> None:
    """Replace x by A x + B u; `following` holds the new values until all are known."""
    combined(a, x, b, u, following)
    for i in range(len(x)):
        x[i] = following[i]


def wrong_sizes(
    transition: Sequence[float],
    entry: Sequence[float],
    readout: Sequence[float],
    direct: Sequence[float],
    order: int,
    inputs: int,
    outputs: int,
) -> Iterator[tuple[str, str]]:
    """Yield those of the matrices A, B, C and D of a system that have another size, and the size
    they should have.

    >>> list(wrong_sizes([0.9], [1.0, 2.0], [1.0], [0.0], 1, 1, 1))
    [('entry', '1 numbers, 1 by 1')]
    """
    sizes = {
        "transition": (transition, order, order),
        "entry": (entry, order, inputs),
        "readout": (readout, outputs, order),
        "direct": (direct, outputs, inputs),
    }
    for name, (matrix, rows, columns) in sizes.items():
        if len(matrix) != rows * columns:
            yield name, f"{rows * columns} numbers, {rows} by {columns}"
