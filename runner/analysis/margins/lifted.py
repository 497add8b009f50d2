"""The figures of a loop opened at a wire that has several values in a common period, of which more than one matters.

No single L exists: L is the matrix of the lifted system (`open_loop`), S and T are matrices whose size is the largest
singular value. Gain and phase margin are the factor and the turn at the wire that put a pole of the closed period on
the unit circle; the delay margin is the number of whole samples before the first that does (`delays`). Crossovers are
those of the response at the input's own frequency, found by a sweep.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.linalg

from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.margins.continuation import stable_intervals
from proofmass.runner.analysis.margins.delays import delay_margin
from proofmass.runner.analysis.margins.figures import LARGEST_FACTOR, FactorInterval, Figures
from proofmass.runner.analysis.margins.frequencies import MOST_CROSSOVERS, Samples, crossings, sweep

_FACTORS = 24  # of a decade, between which poles are followed
_TURNS = 180  # of half a circle
_PEAK = 1e-9  # relative accuracy of the height of a peak
_ON_CIRCLE = 1e-7  # distance from the unit circle within which an eigenvalue counts as on it
_BEFORE = 0.1  # part of the distance of the slowest pole within which it does
_LEAST = 1e-6  # part of the offset by which a level is above it: the size of any T that never answers at once
_FEW = 64  # rows of a matrix of which all singular values are computed
_eigh: Any = scipy.linalg.eigh


def figures_of(system: OpenLoop, stable: bool) -> Figures:
    """All figures of a loop; the margins only of a stable one."""
    w = sweep(system)
    response = Samples.on(w, system.response)
    gains = crossings(response, lambda values: np.abs(values) - 1.0)
    phases = _phase_crossovers(system, response)
    hertz = 1.0 / (2.0 * math.pi)
    every = Figures(
        gain_crossovers=tuple(v * hertz for v in gains),
        gain_crossover_phases=tuple(np.angle(-system.response(np.array(gains))).tolist()),
        phase_crossovers=tuple(v * hertz for v in phases),
        phase_crossover_gains=tuple(np.abs(system.response(np.array(phases))).tolist()),
        stable_gains=stable_gains(system),
    )
    if not stable:
        return every
    low, high = limits(every.stable_gains)
    at, peak = largest(system, 1.0)
    return every.with_values(
        gain_margin=None if math.isinf(high) else high,
        gain_reduction=low or None,
        phase_margin=critical_turn(system),
        delay_margin=delay_margin(system),
        disk_margin=1.0 / largest(system, 0.5)[1],
        sensitivity_peak=peak,
        sensitivity_peak_frequency=at * hertz,
        bandwidth=_bandwidth(system, w),
    )


def limits(gains: Sequence[FactorInterval]) -> FactorInterval:
    """Return the factors next to 1 between which a loop is stable."""
    return next((pair for pair in gains if pair[0] < 1.0 < pair[1]), (1.0, 1.0))


def largest(system: OpenLoop, offset: float) -> tuple[float, float]:
    """Angular frequency and value of the largest |offset - T|, T = L (I + L)^-1, between rest and half the rate.

    Some singular value crosses a level just above the largest value that is known if and only if there is a larger one:
    it lies between two crossings (Bruinsma and Steinbuch, Systems and Control Letters 14, 1990, 287). Where a narrow
    peak comes too near to its level to be told apart, no place between them is higher.
    """
    maps, period, eye = system.by_values, system.map.period, np.eye(system.per_period)
    near = min(_ON_CIRCLE, _BEFORE * float(np.min(1.0 - np.abs(system.poles), initial=1.0)))
    ends = np.array([0.0, math.pi])
    sizes = {
        angle: _norm(offset * eye - matrix.real)  # real there, which takes a quarter of the time
        for angle, matrix in zip(ends.tolist(), system.complementary(ends / period), strict=True)
    }
    more = np.abs(np.angle(system.poles))
    while True:
        at = max(sizes, key=lambda angle: sizes[angle])
        best = sizes[at]
        level = max(best * (1.0 + _PEAK), abs(offset) * (1.0 + _LEAST))
        crossed = maps.crossed(level, offset, near, system.hidden)
        if not crossed:
            return at / period, best
        marks = np.unique(np.abs([*ends, *crossed]))
        angles = np.setdiff1d([*(0.5 * (marks[:-1] + marks[1:])), *more], [*sizes])
        matrices = system.complementary(angles / period)
        sizes |= {angle: _norm(offset * eye - m) for angle, m in zip(angles.tolist(), matrices, strict=True)}
        if max(sizes.values()) <= best * (1.0 + _PEAK):
            return at / period, best
        more = more[:0]


def _norm(matrix: npt.NDArray[Any]) -> float:
    """Return the largest singular value: by the squares, which leave the largest its accuracy, if there are many.

    Iterations from a random vector need ten times as long where the next singular values are near.
    """
    if len(matrix) <= _FEW:
        return float(np.linalg.norm(matrix, 2))
    last = len(matrix) - 1
    (square,) = _eigh(matrix.conj().T @ matrix, eigvals_only=True, subset_by_index=[last, last], overwrite_a=True)
    return math.sqrt(float(square))


def stable_gains(system: OpenLoop) -> tuple[FactorInterval, ...]:
    """Return the intervals of factors at the wire with which the loop is stable; up to a billion counts as any."""
    last = math.log(LARGEST_FACTOR)
    places = np.linspace(-last, last, round(2.0 * last * _FACTORS / math.log(10.0)) + 1)
    intervals = stable_intervals(lambda x: system.growths(np.exp(x)), places)
    return tuple(
        (0.0 if low == -last else math.exp(low), math.inf if high == last else math.exp(high))
        for low, high in intervals
    )


def critical_turn(system: OpenLoop) -> float | None:
    """Return the least turn at the wire that makes a stable loop unstable."""
    places = np.linspace(0.0, math.pi, _TURNS + 1)
    _, turn = next(stable_intervals(lambda x: system.growths(np.exp(-1j * x)), places), (0.0, 0.0))
    return None if turn == math.pi else turn


def _phase_crossovers(system: OpenLoop, response: Samples) -> list[float]:
    """Return where the response is real and negative: every other time that it is real, as it is at half the rate."""
    ends = [math.pi / system.sample]
    found = crossings(response.up_to(ends[0] * (1.0 - 1e-9)), lambda values: values.imag, 2 * MOST_CROSSOVERS) + ends
    return [v for v, answer in zip(found, system.response(np.array(found)), strict=True) if answer.real < 0.0]


def _bandwidth(system: OpenLoop, w: Any) -> float | None:
    """Return where the closed loop, at the frequency of what goes in, first falls 3 dB below its value at rest."""
    closed = Samples.on(np.array([0.0, *w]), system.closed_response)
    at_rest = float(abs(closed.answer(np.zeros(1))[0]))
    if at_rest == 0.0:
        return None
    fallen = crossings(closed, lambda values: np.abs(values) / at_rest - math.sqrt(0.5), 1)
    return fallen[0] / (2.0 * math.pi) if fallen else None
