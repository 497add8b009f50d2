"""Poles, their distance from the boundary of stability, and how well that is known.

A pole p moves by w dA v / (w v) when the numbers of its matrix change by dA, v and w its right and
left vectors (Golub and Van Loan, Matrix Computations, 7.2.2). The error of each number is its
rounding and, at an operating point that is not at rest, its change until it is. A verdict within
that error is "marginal", neither stable nor unstable.

A number of a period is a sum over its ticks, of terms that may be larger: its rounding is that of
the geometric mean of the largest numbers in its row and in its column. Roundings are taken as
independent. Where numbers belong together, as in an integrator and the difference that undoes it,
that is far too much; so they count up to 1e-12 only.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import flint
import numpy as np
import scipy.linalg
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from proofmass.runner.analysis.linearisation.balance import balanced
from proofmass.runner.analysis.linearisation.rational import (
    LARGEST_CERTIFIED,
    LARGEST_ORDER,
    characteristic,
    roots,
)
from proofmass.runner.host.arrays import Array, Complex
from proofmass.runner.host.precision import precision

Verdict = Literal["stable", "marginal", "unstable"]
_ROUNDINGS = 8  # roundings of each number of a loop in a tick
_EXACT_BITS = 12  # a number of so few bits is exact, as 0, 1 or 1/2, not a result of arithmetic
_SETTLING = 10.0  # time constants of the slowest other mode, in which a point may move
_EPSILON = float(np.finfo(float).eps)
_LARGEST = 1e-12  # largest distance by which roundings move a pole
_SLOWEST = 1e-5  # a mode's distance from the boundary of stability above which it settles
_MOVING = 1e-2  # largest distance by which a moving operating point moves a pole
_APART = 2.0**-150  # offset from a pole at which its vectors are solved for
_APART_IN_DOUBLES = 1e-11
_eig: Any = scipy.linalg.eig


@dataclass(frozen=True)
class Pole:
    """A pole; its distance inside the boundary of stability, negative outside, and how well that is known.

    The distance is 1 - |z| of a sampled loop, and -Re s of a continuous one.
    """

    value: complex
    distance: float
    uncertainty: float

    @property
    def verdict(self) -> Verdict:
        """The verdict on a loop with this pole."""
        if abs(self.distance) <= self.uncertainty:
            return "marginal"
        return "stable" if self.distance > 0.0 else "unstable"


@dataclass(frozen=True)
class Variation:
    """Change of a closed matrix from one period to the next, and the turn of its modes by that.

    An orbit that turns takes each mode along: the pole of the whole orbit differs from that of one
    period by the turn.
    """

    change: Array  # of each entry
    poles: Complex
    turns: Array  # of the mode of each pole, as a distance of the pole

    def turn(self, pole: complex) -> float:
        """Return the turn of the mode of a pole."""
        return float(self.turns[np.argmin(np.abs(self.poles - pole))])


def together(poles: Iterable[Pole]) -> tuple[Verdict, tuple[Pole, ...]]:
    """Unstable where a pole is, else marginal where one is, else stable; and the poles, the slowest first."""
    slowest = tuple(sorted(poles, key=lambda pole: (pole.distance, pole.value.imag)))
    verdicts = {pole.verdict for pole in slowest}
    return "unstable" if "unstable" in verdicts else "marginal" if "marginal" in verdicts else "stable", slowest


def judged(
    closed: Array, sampled: bool, variation: Variation | None = None, ticks: int = 1
) -> tuple[Verdict, tuple[Pole, ...]]:
    """Return verdict and poles of a closed transition matrix over some ticks, hidden modes included.

    They are those of its parts, of states that all act on each other: what one part does to another
    moves no pole.
    """
    found = list[Pole]()
    for part in parts_of(closed if variation is None else np.abs(closed) + variation.change):
        own = np.ix_(part, part)
        if len(part) > LARGEST_ORDER:
            found += _computed(closed[own], sampled)
            continue
        moved = variation and replace(variation, change=variation.change[own])
        found += judge(roots(characteristic(closed[own])), closed[own], sampled, moved, ticks)
    return together(found)


@precision()
def judge(
    balls: Sequence[Any], closed: Array, sampled: bool, variation: Variation | None = None, ticks: int = 1
) -> list[Pole]:
    """Return the poles of a closed transition matrix from its roots as balls.

    `variation` is None where periods are alike. `ticks` is how many ticks a period has: each adds
    its roundings to the entries.
    """
    distances = [_distance(root, sampled) for root in balls]
    alike, scale = balanced(closed)
    counted = inexact(alike)
    sizes = np.abs(alike) * counted
    rounding = np.sqrt(np.outer(sizes.max(axis=1, initial=0.0), sizes.max(axis=0, initial=0.0)))
    rounding *= _ROUNDINGS * ticks * _EPSILON * counted
    reach, moving = _LARGEST, np.zeros_like(rounding)
    if variation is not None:
        settling = 1.0 - np.abs(variation.poles)
        slowest = float(np.min(settling, where=settling > _SLOWEST, initial=1.0))
        reach, moving = _MOVING, variation.change / scale[:, None] * scale * (1.0 + _SETTLING / slowest)
    poles: list[Pole] = []
    for root, distance in zip(balls, distances, strict=True):
        size = 1.0 if sampled else max(abs(complex(root)), 1e-300)
        uncertainty = _EPSILON * size
        if abs(distance) <= reach * size and len(closed):
            right, left = _vectors(alike, root)
            between = abs(np.sum(left * right))
            shifts = [float(np.abs(left) @ change @ np.abs(right)) for change in (rounding, moving)]
            limits = (_LARGEST * size, _MOVING * size)
            uncertainty += sum(
                min(change / float(between), limit) if between > change / limit else limit
                for change, limit in zip(shifts, limits, strict=True)
                if change > 0.0
            )
            uncertainty += min(variation.turn(complex(root)), _MOVING) if variation is not None else 0.0
        poles.append(Pole(complex(root), distance, uncertainty))
    if variation is not None:  # what moves a pole hides what roundings do
        return poles
    values, moved = np.array([pole.value for pole in poles]), np.array([pole.uncertainty for pole in poles])
    doubtful = moved > _EPSILON * np.abs(values)
    return [_with_those_beside(poles, i, values, moved) if own else poles[i] for i, own in enumerate(doubtful)]


def _with_those_beside(poles: Sequence[Pole], place: int, values: Complex, moved: Array) -> Pole:
    """Return a pole that may be where another is, from which roundings can hardly tell it: their shifts add up then."""
    pole, apart = poles[place], np.abs(values - values[place])
    near = apart <= 2.0 * (pole.uncertainty + moved)
    near[place] = False
    return replace(pole, uncertainty=pole.uncertainty + float(apart[near].max())) if near.any() else pole


def _distance(root: Any, sampled: bool) -> float:
    if not sampled:
        return 0.0 if root.real.contains(0) else -float(root.real)
    size = abs(root)
    return 0.0 if size.contains(1) else float(1 - size)


def parts_of(a: Array) -> list[list[int]]:
    """Return sets of states that all act on each other, each after those that act on it."""
    if not len(a):
        return []
    _, numbers = connected_components(csr_array(a != 0.0), connection="strong")  # what acts has a smaller one
    order = np.argsort(numbers, kind="stable")
    return [part.tolist() for part in np.split(order, np.flatnonzero(np.diff(numbers[order])) + 1)]


def _vectors(a: Array, root: Any) -> tuple[Array, Array]:
    """Return right and left eigenvectors with largest entry 1, by inverse iteration in balls, part by part."""
    shift = root.mid() + flint.acb(_APART, _APART)
    vectors, parts = [], parts_of(a)
    for turned, order in ((a, parts), (a.T, parts[::-1])):
        vector = [flint.acb(i).cos() for i in range(len(a))]  # in no direction of its own
        for _ in range(2):
            solved = _solved(turned, shift, order, vector)
            largest = max(solved, key=lambda value: float(abs(value).log()) if value != 0 else -math.inf)
            vector = [value / largest for value in solved]
        vectors.append(np.array([complex(value) for value in vector]))
    return vectors[0], vectors[1]


def _solved(a: Array, shift: Any, parts: Sequence[Sequence[int]], vector: Sequence[Any]) -> list[Any]:
    """Return the middles of (A - shift)^-1 times a vector, each part by what acts on it."""
    solved = [flint.acb(0)] * len(a)
    for part in parts:
        rows = a[part]
        others = [j for j in np.flatnonzero(rows.any(axis=0)).tolist() if j not in part]
        known = [vector[i] for i in part]
        if others:  # a product of matrices takes less time than its terms
            acting = flint.acb_mat(rows[:, others].tolist()) * flint.acb_mat(
                len(others), 1, [solved[j] for j in others]
            )
            known = [value - by for value, by in zip(known, acting.entries(), strict=True)]
        if len(part) > LARGEST_CERTIFIED:
            for i, value in zip(part, _solved_in_doubles(a[np.ix_(part, part)], shift, known), strict=True):
                solved[i] = value
            continue
        matrix = [[flint.acb(a[i, j]) - (shift if i == j else 0) for j in part] for i in part]
        made = flint.acb_mat(matrix).solve(flint.acb_mat(len(part), 1, known))
        for i, value in zip(part, made.entries(), strict=True):
            solved[i] = value.mid()
    return solved


def _solved_in_doubles(a: Array, shift: Any, known: Sequence[Any]) -> list[Any]:
    """Return the same of a part of many states, with the shift a little further from the pole."""
    # start-up time: this part of SciPy takes 0.1 s
    import scipy.sparse.linalg

    offset = complex(shift) + _APART_IN_DOUBLES * (1.0 + 1.0j)
    less = scipy.sparse.csc_array(a - offset * np.eye(len(a)))
    largest = max(abs(complex(value)) for value in known) or 1.0
    solved = scipy.sparse.linalg.splu(less).solve(np.array([complex(value) / largest for value in known]))
    return [flint.acb(value.real, value.imag) * largest for value in solved.tolist()]


def inexact(matrix: Array) -> Array:
    """Return one where a number is the result of arithmetic, zero where exact: of few bits."""
    fractions = np.frexp(matrix)[0] * 2.0**_EXACT_BITS
    return np.asarray(fractions != np.round(fractions), dtype=float)


def _computed(closed: Array, sampled: bool) -> Iterable[Pole]:
    """Yield the poles of a large matrix in floating point, with their errors."""
    alike, _ = balanced(closed)
    values, left, right = _eig(alike, left=True, right=True)
    with np.errstate(divide="ignore"):
        lengths = np.linalg.norm(left, axis=0) * np.linalg.norm(right, axis=0) * np.linalg.norm(alike)
        errors = _ROUNDINGS * _EPSILON * lengths / np.abs(np.einsum("ij,ij->j", left.conj(), right))
    distances = 1.0 - np.abs(values) if sampled else -values.real
    for value, distance, error in zip(values.tolist(), distances.tolist(), errors.tolist(), strict=True):
        yield Pole(value, distance, min(error, _LARGEST))
