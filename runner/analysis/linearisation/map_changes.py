"""Differences of two maps over a period: in what one block does to another, and in the response between wires.

A response is C (z - A)^-1 B + D of a map at some points: by how much it changes with some rows or
columns of it. Norms are those of Frobenius. A period of noise has thousands of columns, which count
through B B' and B D' alone. Where rows of A change by E, (z - A - E)^-1 follows from (z - A)^-1 by
as many rows (Sherman, Morrison, Woodbury).
"""

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg

from proofmass.runner.analysis.linearisation.balance import balanced
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.poles import Variation
from proofmass.runner.derivatives.stepped_ticks import Indices
from proofmass.runner.host.arrays import Array, Complex

LOOKS = (1, 2, 8, 64)  # periods after which a map is compared
NEAR = 1e-3  # distance of a pole from the boundary of stability
_NEGLIGIBLE = 1e-9  # part of a map, of all of it
_ENTRIES = 1 << 15  # numbers of two maps that are compared at a time
_NO_MODE = 1e-290  # product of its two vectors, below which a mode counts as one with the next
_PLACES = (0.01, 0.3, 1.1, 2.3)  # rad a period: no carrier, of a rational turn, is there
_eig: Any = scipy.linalg.eig
Parts = tuple[Array, Array, Array, Array]
Norms = tuple[Array, Array]  # the larger of those before and after a change, and that of the change, at each point


class ChangedResponse:
    """The response of A, B, C and D."""

    def __init__(self, parts: Parts, z: Complex) -> None:
        self._a, self._b, self._c, self._d = parts
        self._inverse = np.linalg.inv(z[:, None, None] * np.eye(len(self._a)) - self._a).astype(np.complex128)

    def changed(self, rows: Indices, columns: Indices, change: Array) -> Norms:
        """Return the norms where some rows of [A B; C D], of states or of outputs, change by so much.

        Columns are those of states or those of inputs.
        """
        n, own = len(self._b), np.flatnonzero(change.any(axis=0))
        columns, change = columns[own], change[:, own]
        if columns[0] >= n:
            across, square = self._of_inputs(rows, columns - n, change)
        elif rows[0] >= n:
            across, square = self._of_outputs(rows - n, columns, change)
        else:
            across, square = self._of_states(rows, columns, change)
        size = np.maximum(np.maximum(self._square, self._square + 2.0 * np.real(across) + square), 0.0)
        return np.sqrt(size), np.sqrt(np.maximum(square, 0.0))

    def _of_inputs(self, rows: Indices, columns: Indices, change: Array) -> tuple[Complex, Array]:
        """Return the product with the change, and its square, where columns of B, and of D below it, change."""
        n = len(self._b)
        into, direct = self._b[:, columns] @ change.T, self._d[:, columns]
        if rows[0] >= n:
            outputs = rows - n
            across = np.sum(self._heard[:, outputs] * into.T, axis=(1, 2)) + np.sum(direct[outputs] * change)
            return across, np.full(len(across), np.sum(change**2))
        left = self._heard[:, :, rows]
        across = np.sum((self._heard @ into + direct @ change.T) * left.conj(), axis=(1, 2))
        return across, np.real(np.sum((left @ (change @ change.T)) * left.conj(), axis=(1, 2)))

    def _of_outputs(self, rows: Indices, columns: Indices, change: Array) -> tuple[Complex, Array]:
        """Return the same where rows of C change."""
        moved = change @ self._entered[:, columns]
        across = np.sum(self._c[rows] @ self._entered * moved.conj(), axis=(1, 2))
        across += np.sum((change @ self._inverse[:, columns]) * self._direct.T[rows], axis=(1, 2))
        return across, _square(moved)

    def _of_states(self, rows: Indices, columns: Indices, change: Array) -> tuple[Complex, Array]:
        """Return the same where rows of A change: by a product of few columns and as many rows."""
        right = change @ self._inverse[:, columns]
        after = np.linalg.inv(np.eye(len(rows)) - right[:, :, rows])
        down, moved = self._read[:, :, rows] @ after, change @ self._entered[:, columns]
        across = np.sum((down.conj().transpose(0, 2, 1) @ self._between).conj() * moved, axis=(1, 2))
        across += np.sum((right @ self._direct) * (self._heard[:, :, rows] @ after).transpose(0, 2, 1), axis=(1, 2))
        return across, _square(np.linalg.qr(down, mode="r") @ moved)

    @cached_property
    def _heard(self) -> Complex:
        return np.asarray(self._c @ self._inverse)

    @cached_property
    def _square(self) -> Array:
        if self._b.shape[1] < len(self._b):
            return _square(self._heard @ self._b + self._d)
        both = np.real(np.sum((self._heard @ (self._b @ self._b.T)) * self._heard.conj(), axis=(1, 2)))
        direct = 2.0 * np.real(np.sum(self._heard * self._direct.T, axis=(1, 2)))
        return np.asarray(both + direct + np.sum(self._d**2))

    @cached_property
    def _direct(self) -> Array:
        return np.asarray(self._b @ self._d.T)

    @cached_property
    def _outputs(self) -> Array:
        """Rows with the norms of C, as many as there are states at most."""
        return np.linalg.qr(self._c)[1]

    @cached_property
    def _entered(self) -> Complex:
        """Columns that enter, with the norms of B, as many as there are states at most."""
        return np.asarray(self._inverse @ np.linalg.qr(self._b.T)[1].T)

    @cached_property
    def _read(self) -> Complex:
        return np.asarray(self._outputs @ self._inverse)

    @cached_property
    def _between(self) -> Complex:
        return np.asarray(self._outputs @ self._entered)


def _square(matrices: Complex) -> Array:
    return np.asarray(np.sum(np.abs(matrices) ** 2, axis=(1, 2)))


def pole_rates(of_period: PeriodMap) -> Array:
    """Return by how much each mode decays, grows or turns in a map, the slowest first."""
    poles = np.linalg.eigvals(of_period.moved_between()).astype(complex)
    return np.sort(np.abs(np.log(poles + 1e-300)))


def change_between(first: PeriodMap, second: PeriodMap) -> float:
    """Return the largest relative change between two maps of the effect of one block on another, in balanced units."""
    if (first.states, first.inputs, first.outputs) != (second.states, second.inputs, second.outputs):
        return math.inf
    if np.array_equal(first.matrix[:, :-1], second.matrix[:, :-1]):
        return 0.0
    kept = first.between_with(second)
    squares = _squares(first, second, kept)
    scale = np.outer(*_scales(squares[0])) ** 2
    wires = ([*{entry[:2]: entry for entry in ends}.values()] for ends in (first.outputs, first.inputs))
    down, across = (_members([first.states[place] for place in kept], ends) for ends in wires)
    parts, changes = (np.sqrt(down @ (each * scale) @ across.T) for each in squares)
    counted = parts > _NEGLIGIBLE * math.sqrt(float(np.sum(squares[0] * scale)))
    return float(np.max(changes[counted] / parts[counted], initial=0.0))


def _squares(first: PeriodMap, second: PeriodMap, kept: Sequence[int]) -> tuple[Array, Array]:
    """Return the squares of the larger entries of two maps, less 1 on the diagonal, and of their differences.

    They are sums for each of the states that are kept, and for each wire with all of its values. A
    period of noise may have millions of entries, of which few rows are in a cache.
    """
    n, m = len(kept), first.order
    down, across = (_alone(n, ends) for ends in (first.outputs, first.inputs))
    rows, columns = (
        np.array([*kept, *range(m, m + len(ends))], dtype=np.int64) for ends in (first.outputs, first.inputs)
    )
    made = np.zeros((2, down.max(initial=-1) + 1, across.max(initial=-1) + 1))
    begins, eye = np.flatnonzero(np.diff(across, prepend=-1)), np.eye(len(rows), n)
    step = max(1, _ENTRIES // max(1, len(columns)))
    for some in (slice(begin, begin + step) for begin in range(0, len(rows), step)):
        one, two = (of.matrix[rows[some]][:, columns] for of in (first, second))
        for matrix in (one, two):
            matrix[:, :n] -= eye[some]
        for of, entries in zip(made, (np.maximum(np.abs(one), np.abs(two)), two - one), strict=True):
            sums = np.add.reduceat(entries**2, begins, axis=1) if len(begins) else entries
            np.add.at(of, (down[some, None], across[begins]), sums)
    return made[0], made[1]


def same_between(first: PeriodMap, closed: PeriodMap, periods: int) -> bool:
    """Return whether a map again and again answers as a map over so many periods, to rounding.

    Oscillations exp(iwt) come in; both answers are rational in exp(iw), so that a few places in general position tell.
    """
    direct, (rows, columns) = closed.parts()[3], first.parts()[3].shape
    if direct.shape != (periods * rows, periods * columns):
        return False
    turns = np.exp(1j * np.outer(_PLACES, np.arange(periods)))[:, :, None, None]
    once, whole = (_responses(of.between(), np.array(_PLACES) * n) for of, n in ((first, 1), (closed, periods)))
    coming = (turns * np.eye(columns)).reshape(len(_PLACES), -1, columns)
    expected = (turns * once[:, None]).reshape(len(_PLACES), -1, columns)
    size = np.max(np.abs(expected), initial=0.0)
    return bool(np.max(np.abs(whole @ coming - expected), initial=0.0) <= _NEGLIGIBLE * size)


def _responses(of: PeriodMap, angles: Array) -> Complex:
    """Return the responses of a map at angles of the unit circle."""
    a, b, c, d = of.parts()
    z = np.exp(1j * angles)[:, None, None]
    inside = np.linalg.solve(z * np.eye(len(a)) - a, np.broadcast_to(b, (len(z), *b.shape)))
    return np.asarray(d + c @ inside, dtype=np.complex128)


def effect(first: PeriodMap, second: PeriodMap, z: Complex) -> float:
    """Return the largest relative change of a response where what one block does to another is as in the second map."""
    if (first.states, first.inputs, first.outputs) != (second.states, second.inputs, second.outputs):
        return math.inf
    if np.array_equal(first.matrix[:, :-1], second.matrix[:, :-1]):
        return 0.0
    kept = first.between_with(second)
    first, second = first.kept(kept), second.kept(kept)
    changes = [0.0]
    response = ChangedResponse(first.parts(), z)
    down, across = (_members(first.states, ends) for ends in (first.outputs, first.inputs))
    for places in np.argwhere(down @ (first.matrix[:, :-1] != second.matrix[:, :-1]) @ across.T).tolist():
        rows, columns = (np.flatnonzero(of[place]) for of, place in zip((down, across), places, strict=True))
        pair = np.ix_(rows, columns)
        size, moved = response.changed(rows, columns, second.matrix[pair] - first.matrix[pair])
        changes.append(float(np.max(np.divide(moved, size, out=np.zeros_like(size), where=size > 0.0))))
    return max(changes)


def variation(closed: Array, later: Sequence[Array]) -> Variation:
    """Return the changes of the entries of a closed transition matrix, as far as they move poles near the boundary.

    An orbit that turns changes the matrix to one that is similar: w* (dA) v is much less than |w|
    |dA| |v|. It may vanish at an instant, so that several later matrices are looked at, those after
    1, 2, 8 and 64 periods. The pole of one period still differs from that of the turning orbit, by
    w* (dv) where the mode turns by dv in a period.
    """
    change = np.abs(later[0] - closed)
    alike, scale = balanced(closed)
    matrices = [matrix / scale[:, None] * scale for matrix in later]
    poles, left, right = _eig(alike, left=True, right=True)
    between = np.abs(np.einsum("ji,ji->i", left.conj(), right))
    bounds = np.einsum("ki,ki->i", np.abs(left), np.abs(matrices[0] - alike) @ np.abs(right))
    shifts = np.max(
        [
            np.abs(np.einsum("ki,ki->i", left.conj(), (matrix - alike) @ right)) / periods
            for periods, matrix in zip(LOOKS, matrices, strict=False)
        ],
        axis=0,
    )
    distances = np.abs(1.0 - np.abs(poles))
    near = distances <= max(NEAR, float(np.min(distances, initial=1.0)))
    parts = np.divide(shifts, bounds, out=np.ones_like(bounds), where=bounds > 0.0)[near]
    whole = np.full_like(bounds, math.inf)
    reach = 2.0 * np.divide(bounds, between, out=whole.copy(), where=between > 0.0)
    turned = np.abs(np.einsum("ji,ji->i", left.conj(), _turned(matrices[0], poles, right, reach) - right))
    turns = np.divide(turned, between, out=whole, where=between > 0.0)
    return Variation(change * min(float(np.max(parts, initial=0.0)), 1.0), poles.astype(complex), turns)


def _turned(later: Array, poles: Complex, vectors: Complex, reach: Array) -> Complex:
    """Return vectors of modes turned into the modes of a later matrix whose poles may be theirs, as long as before."""
    values, left, right = _eig(later, left=True, right=True)
    between = np.einsum("ji,ji->i", left.conj(), right)
    parts = left.conj().T @ vectors
    parts = np.divide(parts, between[:, None], out=np.zeros_like(parts), where=np.abs(between[:, None]) > _NO_MODE)
    theirs = np.abs(values[:, None] - poles) <= np.maximum(reach, np.min(np.abs(values[:, None] - poles), axis=0))
    turned = (right @ np.where(theirs, parts, 0.0)).astype(complex)
    largest = np.max(np.abs(turned), axis=0, initial=0.0)
    turned = np.divide(turned, largest, out=turned, where=largest > 0.0)  # squares of what is large would overflow
    sizes = np.linalg.norm(turned, axis=0)
    return np.asarray(np.divide(turned, sizes, out=vectors.astype(complex), where=sizes > 0.0))


def _scales(joined: Array) -> tuple[Array, Array]:
    """Return factors of rows and columns that make them alike: units of the states and wires do not count.

    They are squares. A wire behind the states that has no row, or no column, keeps its unit: all of
    these are one of their norm.
    """
    paired = min(joined.shape)
    square = np.zeros((paired + 1, paired + 1))
    square[:paired, :paired] = joined[:paired, :paired]
    square[:paired, paired] = joined[:paired, paired:].sum(axis=1)
    square[paired, :paired] = joined[paired:, :paired].sum(axis=0)
    own = np.ones(max(joined.shape))
    own[:paired] = balanced(np.sqrt(square))[1][:paired]
    return 1.0 / own[: len(joined)], own[: joined.shape[1]]


def _alone(n: int, ends: Sequence[tuple[str, str, int]]) -> Indices:
    """Return a number for each of n states, and for each wire behind them."""
    wires = {key: n + number for number, key in enumerate(dict.fromkeys(entry[:2] for entry in ends))}
    return np.array([*range(n), *(wires[entry[:2]] for entry in ends)], dtype=np.int64)


def _members(states: Sequence[tuple[str, str, int]], ends: Sequence[tuple[str, str, int]]) -> Array:
    """Return a row for the states of each block, and for the values of each wire, with one at their places."""
    groups: list[Any] = [*(name for name, _, _ in states), *(entry[:2] for entry in ends)]
    rows = {group: row for row, group in enumerate(dict.fromkeys(groups))}
    members = np.zeros((len(rows), len(groups)))
    members[[rows[group] for group in groups], np.arange(len(groups))] = 1.0
    return members
