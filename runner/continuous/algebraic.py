"""Algebraic loops: equations u = g(u) for the values u of the tears, solved by damped Newton's method.

    u <- u + s d,   (J - 1) d = u - g(u),   s = 1, 1/2, 1/4, ... until the distance from u to g(u) is less than before

(Deuflhard, Newton Methods for Nonlinear Problems, 2004, section 3.1.) J are the derivatives of g by
differences: they decide how fast it converges, not where to. Everything is in relation to the
largest value that an unknown or what is found for it had in this solution, so that the units of the
wires do not matter, and a linear loop has a solution that is linear to the last bit where values
are scaled by powers of two.

Plain Python runs `solve` on lists, the compiled loop on arrays, both to the same bits.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from proofmass.runner.continuous.linear_equations import Flat, factorise, substitute

ITERATIONS = 50
NUDGE = 1e-7  # for the derivatives
CONVERGED = 1e-8  # below this change a step that gets no closer counts as rounding
EXACT = 1e-15  # distance from u to g(u) at which no further change is tried
AGREED = 1e-6  # distance of a solution: more is a jump of g
FARTHEST = 1e6  # largest change: by differences a loop gain so near to one cannot be told from one
SHORTEST = 1e-9  # s


class NoSolutionError(ArithmeticError):
    """A loop that Newton's method finds no solution of: `at` is the wire of its first unknown."""

    def __init__(self, at: str) -> None:
        super().__init__("Newton's method finds no solution of the algebraic loop")
        self.at = at


class _Loop(NamedTuple):
    """Equations, values and sizes of the unknowns, g of them, and other values with theirs."""

    equations: Any
    context: Any
    unknown: Flat
    image: Flat
    size: Flat
    ahead: Flat
    image_ahead: Flat


def scratch(n: int) -> tuple[int, ...]:
    """Return the lengths of the sequences that `solve` works on, for n unknowns."""
    return (n, n, n, n, n, n * n, n)


def solve(equations: Any, context: Any, unknown: Flat, work: Any) -> None:
    """Replace the guess in `unknown` by a solution, or by NaN.

    `equations(context, unknown, image)` writes g of the unknowns, or something not finite where g
    has no value; `work` is scratch.
    """
    image, ahead, image_ahead, size, change, matrix, order = work
    loop, n = _Loop(equations, context, unknown, image, size, ahead, image_ahead), len(unknown)
    for i in range(n):
        size[i] = 0.0
    equations(context, unknown, image)
    solved, possible = False, math.isfinite(_distance(unknown, image, size))
    for _ in range(ITERATIONS):
        if possible and not solved:
            for i in range(n):
                size[i] = max(size[i], abs(unknown[i]), abs(image[i]))
            _differentiate(loop, matrix)
            for i in range(n):
                matrix[i * n + i] -= 1.0
                change[i] = unknown[i] - image[i]
            possible = factorise(matrix, n, order)
            if possible:
                substitute(matrix, n, order, change)
                solved, possible = _stepped(loop, change)
    if not solved:
        for i in range(n):
            unknown[i] = math.nan


def _differentiate(loop: _Loop, jacobian: Flat) -> None:
    """Derivatives of g. The nudge has the sign of the values, and the size of others where there is none yet."""
    equations, context, unknown, image, size, nudged, nudged_image = loop
    n = len(unknown)
    largest = 0.0
    for i in range(n):
        nudged[i] = unknown[i]
        largest = max(largest, size[i])
    for j in range(n):
        nudge = NUDGE * (size[j] if size[j] > 0.0 else largest)
        nudged[j] = unknown[j] + math.copysign(nudge, unknown[j] + image[j])
        nudge = nudged[j] - unknown[j]
        equations(context, nudged, nudged_image)
        nudged[j] = unknown[j]
        for i in range(n):
            jacobian[i * n + j] = (nudged_image[i] - image[i]) / nudge if nudge != 0.0 else 0.0


def _stepped(loop: _Loop, change: Flat) -> tuple[bool, bool]:
    """Go as far along the change as the distance gets less; whether the solution is reached, and whether it may be."""
    equations, context, unknown, image, size, ahead, image_ahead = loop
    n = len(unknown)
    small = True
    for i in range(n):
        if size[i] > 0.0 and not abs(change[i]) <= FARTHEST * size[i]:
            return False, False
        small = small and abs(change[i]) <= CONVERGED * size[i]
    distance, share = _distance(unknown, image, size), 1.0
    while share > SHORTEST:
        for i in range(n):
            ahead[i] = unknown[i] + share * change[i]
        equations(context, ahead, image_ahead)
        closer = _distance(ahead, image_ahead, size)
        if closer < distance:
            for i in range(n):
                unknown[i], image[i] = ahead[i], image_ahead[i]
            return small and closer <= EXACT, True
        if small and distance <= AGREED:
            return True, True
        share *= 0.5
    return False, False


def _distance(unknown: Flat, image: Flat, size: Flat) -> float:
    """Return the largest difference between unknowns and image, relative to their sizes; NaN where
    one is not finite.

    Where there is no size yet, the larger of the two values is taken for it.
    """
    worst, broken = 0.0, 0.0
    for i in range(len(unknown)):
        difference = abs(image[i] - unknown[i])
        whole = size[i] if size[i] > 0.0 else max(abs(image[i]), abs(unknown[i]))
        worst = max(worst, difference / whole if whole > 0.0 else 0.0)
        broken += difference - difference
    return worst + broken


def solve_in_place(tears: Sequence[Any], others: Sequence[Any], signals: Any, value: Callable[[Any], float]) -> bool:
    """Solve a loop in plain Python: `signals` hold guesses of the tears, then the solution, or NaN.

    `value(node)` is what a node gives with the signals as they are. Whether there is a solution.
    """

    def equations(context: None, unknown: list[float], image: list[float]) -> None:
        for tear, guess in zip(tears, unknown, strict=True):
            signals[tear] = guess
        total = 0.0
        try:
            for node in others:
                signals[node] = value(node)
                total += 0.0 * signals[node]
            image[:] = [value(tear) if total == 0.0 else total for tear in tears]
        except (ArithmeticError, ValueError):
            image[:] = [math.nan] * len(tears)

    unknown = [signals[tear] for tear in tears]
    solve(equations, None, unknown, tuple([0.0] * length for length in scratch(len(tears))))
    for tear, guess in zip(tears, unknown, strict=True):
        signals[tear] = guess
    return not math.isnan(unknown[0])
