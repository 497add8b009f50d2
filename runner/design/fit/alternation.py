"""The alternating iteration (Liu, Li, Shen, section 1, steps 1 to 5; steps 3 and 4 are lost and reconstructed).

1. exponents b are given; 2. with b fixed, a by linear least squares of V on exp(b1 T), exp(b2
T); 3. with a fixed, db by linear least squares of the residual on a1 T exp(b1 T), a2 T exp(b2
T); 4. b += db and the mean square error; 5. steps 2 to 4 again until the error changes by less than
`TOLERANCE` of itself.

The fixed point is the least-squares optimum. Near it each iteration multiplies the distance by
cos^2 of the smallest angle between the spans of steps 2 and 3, which is close to 1: hundreds to
thousands of iterations.
"""

from typing import NamedTuple

import numpy as np

from proofmass.runner.host.arrays import AnyArray

TOLERANCE = 1e-12  # relative change of the mean square error
MOST_ITERATIONS = 20_000
MOST_WORK = 100_000_000  # iterations times rows
LARGEST_ARGUMENT = 300.0  # of an exponential: its square is finite too, and the block takes it


class Alternated(NamedTuple):
    """End of the alternation; `converged` means that it stopped by its own criterion, not that it is optimal."""

    a: tuple[float, float]
    b: tuple[float, float]
    mean_square: float
    iterations: int
    converged: bool


def alternate(
    temperature: AnyArray, output: AnyArray, start: tuple[float, float], tolerance: float = TOLERANCE
) -> Alternated:
    """Alternate from the starting exponents, on unshifted temperatures: shifts change the path."""
    largest = LARGEST_ARGUMENT / float(np.abs(temperature).max())
    most = min(MOST_ITERATIONS, max(1, MOST_WORK // len(temperature)))
    (b1, b2), before, iterations = start, np.inf, 0
    while True:
        iterations += 1
        first, second = np.exp(b1 * temperature), np.exp(b2 * temperature)
        a1, a2 = _two_columns(first, second, output)
        left = output - a1 * first - a2 * second
        mean_square = float(left @ left) / len(left)
        converged = abs(before - mean_square) <= tolerance * mean_square
        before = mean_square
        step1, step2 = _two_columns(a1 * temperature * first, a2 * temperature * second, left)
        inside = max(abs(b1 + step1), abs(b2 + step2)) <= largest
        if converged or not inside or iterations == most:
            return Alternated((a1, a2), (b1, b2), mean_square, iterations, converged)
        b1, b2 = b1 + step1, b2 + step2


def convergence_rate(temperature: AnyArray, a: tuple[float, float], b: tuple[float, float]) -> float:
    """Return cos^2 of the smallest angle between the spans of the two steps: the factor of an error per iteration."""
    waves = np.exp(np.outer(temperature, b))
    spans = [np.linalg.qr(columns)[0] for columns in (waves, temperature[:, None] * waves * np.asarray(a))]
    return float(np.linalg.svd(spans[0].T @ spans[1], compute_uv=False)[0]) ** 2


def _two_columns(first: AnyArray, second: AnyArray, target: AnyArray) -> tuple[float, float]:
    """Solve least squares on two columns, the second made orthogonal to the first: no squared condition number.

    A column that adds nothing gets the factor 0.
    """
    size = float(first @ first)
    if size == 0.0:
        size2 = float(second @ second)
        return 0.0, float(second @ target) / size2 if size2 else 0.0
    part = float(first @ second) / size
    rest = second - part * first
    again = float(first @ rest) / size
    rest, part = rest - again * first, part + again
    length = float(rest @ rest)
    if length <= 1e-30 * float(second @ second):
        return float(first @ target) / size, 0.0
    y = float(rest @ target) / length
    return float(first @ target) / size - part * y, y
