"""Modes that a loop of several wires, or values of its wire in a period, does not see, and the loop
without them.

A closed-loop pole p with the vectors v and w moves by w B' D C' v / (w v) when the wire passes I +
D instead of I; B' and C' are those of the closed loop (Golub and Van Loan, Matrix Computations,
7.2.2). A pole on the boundary of stability that |B'| |C'| cannot move further than it is known is
hidden, such as the phase of an oscillation.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.linalg

from proofmass.runner.analysis.linearisation.balance import balanced
from proofmass.runner.analysis.linearisation.lasting import holders
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.poles import Pole, Verdict, judged, together
from proofmass.runner.analysis.margins.bracketed import HIDDEN
from proofmass.runner.analysis.margins.modes import Mode
from proofmass.runner.host.arrays import Array, Complex

_ROUNDING = 1e-12  # of a sum of vectors' parts, as a pole is known
_eig: Any = scipy.linalg.eig
_schur: Any = scipy.linalg.schur


def seen(system: OpenLoop) -> tuple[OpenLoop, Verdict, tuple[Pole, ...], tuple[Mode, ...]]:
    """Return the visible part of a loop, its verdict, its closed-loop poles, the slowest first, and hidden modes.

    A pole that is nearer to the boundary of stability than growths are followed is no better known.
    """
    visible, poles, hidden = _left_out(system)
    followed = (replace(p, uncertainty=max(p.uncertainty, HIDDEN)) if abs(p.distance) <= HIDDEN else p for p in poles)
    return visible, *together(followed), hidden


def _left_out(system: OpenLoop) -> tuple[OpenLoop, Sequence[Pole], tuple[Mode, ...]]:
    """Return the visible part of a loop, its closed-loop poles and hidden modes."""
    closed = np.real(system.closed())
    _, poles = judged(closed, not system.continuous, system.variation, system.ticks)
    marginal = [pole for pole in poles if pole.verdict == "marginal"]
    if not marginal:
        return system, poles, ()
    alike, scale = balanced(closed)
    values, left, right = _eig(alike, left=True, right=True)
    moved = _moved(system, left, right, scale)
    places = zip(marginal, _places(values, marginal), strict=True)
    hidden = [(pole, i) for pole, i in places if moved[i] <= 2.0 * pole.uncertainty]
    rest = _without(system, alike, scale, [complex(values[i]) for _, i in hidden]) if hidden else None
    if rest is None:
        return system, poles, ()
    names = [entry[0] for entry in system.map.states]
    upper = [(pole, np.abs(right[:, i])) for pole, i in hidden if pole.value.imag >= 0.0]
    modes = tuple(Mode(pole, 1, holders(parts, names), True) for pole, parts in upper)
    return rest, [pole for pole in poles if not any(pole is other for other, _ in hidden)], modes


def _places(values: Complex, poles: Sequence[Pole]) -> list[int]:
    """Return the places of poles among eigenvalues, each once."""
    free, places = list(range(len(values))), []
    for pole in poles:
        nearest = min(free, key=lambda i: abs(values[i] - pole.value))
        free.remove(nearest)
        places.append(nearest)
    return places


def _moved(system: OpenLoop, left: Complex, right: Complex, scale: Array) -> Array:
    """Return how far each closed-loop pole moves, at most, by a change of one at the wire."""
    _, b, c, d = system.matrices
    inverse = np.linalg.inv(np.eye(len(d)) + d)
    into = _sizes(left.conj().T, b @ inverse / scale[:, None])
    out = _sizes(right.T, (inverse @ c * scale).T)
    between = np.abs(np.einsum("ij,ij->j", left.conj(), right))
    return np.asarray(np.divide(into * out, between, out=np.full(len(into), np.inf), where=between > 0.0))


def _sizes(vectors: npt.NDArray[Any], matrix: npt.NDArray[Any]) -> Array:
    """Return the size of each vector times a matrix, 0 where it is no more than rounding makes of its terms."""
    sizes = np.linalg.norm(vectors @ matrix, axis=1)
    terms = np.linalg.norm(np.abs(vectors) @ np.abs(matrix), axis=1)
    return np.asarray(np.where(sizes > _ROUNDING * terms, sizes, 0.0))


def _without(system: OpenLoop, alike: Array, scale: Array, hidden: Sequence[complex]) -> OpenLoop | None:
    """Return the system on the invariant subspace of its other closed-loop poles; None if one of these is the same."""
    every = np.linalg.eigvals(alike)
    distances = np.sort(np.min(np.abs(every[:, None] - np.array(hidden)), axis=1))
    n, count = len(alike), len(hidden)
    apart = 0.5 * (distances[count - 1] + distances[count]) if count < n else math.inf
    form, turn, first = _schur(alike, output="complex", sort=lambda value: min(abs(value - v) for v in hidden) <= apart)
    if first != count:
        return None
    mixed = scipy.linalg.solve_sylvester(form[:count, :count], -form[count:, count:], -form[:count, count:])
    kept = np.block([[np.zeros((count, count)), mixed], [np.zeros((n - count, count)), np.eye(n - count)]])
    others = np.real(turn @ kept @ turn.conj().T)
    alone = np.linalg.svd(others)[0][:, : n - count]
    basis, dual = scale[:, None] * alone, alone.T @ others / scale
    a, b, c, d = system.map.parts()
    matrix = np.block([[dual @ a @ basis, dual @ b, np.zeros((len(dual), 1))], [c @ basis, d, np.zeros((len(c), 1))]])
    states = tuple(("", "mode", i) for i in range(len(dual)))
    ticks = None if system.continuous else system.by_values
    alone_map = replace(system.map, states=states, matrix=matrix, slopes={}, point=(), later=(), ticks=ticks)
    return OpenLoop(alone_map, continuous=system.continuous, hidden=tuple(hidden))
