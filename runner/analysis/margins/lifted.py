"""The figures of a loop opened at a wire that has several values in a common period, of which more
than one matters.

No single L exists: L is the matrix of the lifted system (`open_loop`), S and T are matrices whose
size is the largest singular value. Gain and phase margin are the factor and the turn at the wire
that put a pole of the closed period on the unit circle; the delay margin is the number of whole
samples before the first that does (`delays`). Crossovers are those of the response at the input's
own frequency, found by a sweep.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
import scipy.linalg

from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.margins.axis import AT_REST
from proofmass.runner.analysis.margins.bracketed import stable_intervals
from proofmass.runner.analysis.margins.delays import delay_margin
from proofmass.runner.analysis.margins.figures import LARGEST_FACTOR, FactorInterval, Figures
from proofmass.runner.analysis.margins.frequencies import MOST_CROSSOVERS, Samples, crossings, highest, sweep
from proofmass.runner.host.arrays import Array, Complex

_FACTORS = 24  # of a decade, between which poles are followed
_TURNS = 180  # of half a circle
_PEAK = 1e-9  # relative accuracy of the height of a peak
_ON_CIRCLE = 1e-7  # distance from the unit circle within which an eigenvalue counts as on it
_BEFORE = 0.1  # part of the distance of the slowest pole within which it does
_LEAST = 1e-6  # part of the offset by which a level is above it: the size of any T that never answers at once
_FEW = 64  # values in a period, up to which singular values take less time than levels
_ITERATIONS = 30  # which show the strongest line of a vector
_QUICK = 12  # iterations within which a singular value that stands alone is found
_SAME = 1e-15  # part of a singular value, by which one that is found does not grow any more
_ALIKE = 0.9  # part of the strongest line, from which on another counts as strong
_eigh: Any = scipy.linalg.eigh
_Peak: TypeAlias = tuple[float, float]  # angle over a period, and value
_Crossed: TypeAlias = Callable[[float], list[float]]


def figures_of(system: OpenLoop, stable: bool) -> Figures:
    """All figures of a loop; the margins only of a stable one."""
    w = sweep(system)
    response = Samples.on(w, system.response)
    gains = crossings(response, lambda values: np.abs(values) - 1.0)
    phases = _phase_crossovers(system, response)
    hertz = 1.0 / (2.0 * math.pi)
    every = replace(
        limits(system) if stable else Figures(stable_gains=stable_gains(system)),
        gain_crossovers=tuple(v * hertz for v in gains),
        gain_crossover_phases=tuple(np.angle(-system.response(np.array(gains))).tolist()),
        phase_crossovers=tuple(v * hertz for v in phases),
        phase_crossover_gains=tuple(np.abs(system.response(np.array(phases))).tolist()),
    )
    if not stable:
        return every
    closed = closed_samples(system, w)
    at, peak = largest(system, 1.0, closed)
    return replace(
        every,
        delay_margin=delay_margin(system, every.gain_crossovers),
        disk_margin=1.0 / _peak(system, 0.5, closed)[1],
        sensitivity_peak=peak,
        sensitivity_peak_frequency=at * hertz,
        bandwidth=_bandwidth(closed),
    )


def limits(system: OpenLoop) -> Figures:
    """Return factors and turn at the wire, next to none, that make a stable loop unstable."""
    gains = stable_gains(system)
    low, high = next((pair for pair in gains if pair[0] < 1.0 < pair[1]), (1.0, 1.0))
    return Figures(
        gain_margin=None if math.isinf(high) else high,
        gain_reduction=low or None,
        phase_margin=_critical_turn(system),
        stable_gains=gains,
    )


def closed_samples(system: OpenLoop, w: Array) -> Samples:
    """Return T at the own frequency, at rest and on a grid."""
    return Samples.on(np.array([0.0, *w]), system.closed_response)


def largest(system: OpenLoop, offset: float, closed: Samples) -> tuple[float, float]:
    """Angular frequency and value of the largest |offset - T|, T = L (I + L)^-1, between rest and half the rate.

    Over a period many frequencies turn by the same angle: that of the strongest line of what goes
    in is told.
    """
    angle, peak, at = _peak(system, offset, closed)
    if at is not None:
        return at, peak
    (matrix,) = offset * np.eye(system.per_period) - system.complementary(np.array([angle / system.map.period]))
    return _strongest_line(matrix, angle) / system.map.period, peak


def _peak(system: OpenLoop, offset: float, closed: Samples) -> tuple[float, float, float | None]:
    """Return the angle over a period and the value of the largest, and its frequency if its own
    line is the largest.

    It is no less than at rest, or than that of the response at the own frequency, of which `closed`
    holds samples. Some singular value crosses a level just above the largest at a frequency if and
    only if there is a larger one elsewhere: so the level is raised, by values between crossings if
    a period has few (Bruinsma and Steinbuch, Systems and Control Letters 14, 1990, 287), and else
    by bisection. Where a narrow peak comes too near to its level to be told apart, no place between
    its crossings is higher.
    """
    period, values = system.map.period, system.per_period
    near = min(_ON_CIRCLE, _BEFORE * float(np.min(1.0 - np.abs(system.poles), initial=1.0)))

    def crossed(level: float) -> list[float]:
        return system.by_values.crossed(level, offset, near, system.hidden)

    at, best = highest(closed, lambda response: np.abs(offset - response))
    (rest,) = system.complementary(np.zeros(1)).real  # which takes a quarter of the time of another frequency
    at_rest = _norm(offset * np.eye(values) - rest)
    raised = _raised_by_values if values <= _FEW else _raised_by_levels
    angle, peak = raised(system, offset, max((at * period, best), (0.0, at_rest), key=_height), crossed)
    return angle, peak, at if angle == at * period else None


def _strongest_line(matrix: Complex, angle: float) -> float:
    """Return the angle over a period of the strongest line of what a matrix makes largest; the lower one of a pair."""
    own = np.exp(1j * angle * np.arange(len(matrix)) / len(matrix))
    vector = own if (matrix @ own).any() else own * np.arange(1.0, 1.0 + len(own))  # an integrator lets it not through
    for _ in range(_ITERATIONS):
        vector = ((matrix @ vector).conj() @ matrix).conj()
        vector = vector / np.linalg.norm(vector)
    lines = np.abs(np.fft.fft(vector / own))
    angles = np.abs(angle + 2.0 * math.pi * np.fft.fftfreq(len(matrix), 1.0 / len(matrix)))
    return float(np.min(angles[lines >= _ALIKE * np.max(lines)]))


def _height(peak: _Peak) -> float:
    return peak[1]


def _norm(matrix: Array) -> float:
    """Return the largest singular value: by the squares, which leave the largest its accuracy, if
    there are many.

    Iterations from a random vector take a tenth of the time where it stands alone, and ten times as
    long where the next ones are near.
    """
    if len(matrix) <= _FEW:
        return float(np.linalg.norm(matrix, 2))
    vector, sizes = np.random.default_rng(0).normal(size=len(matrix)), [0.0]
    for _ in range(_QUICK):
        vector = matrix.T @ (matrix @ (vector / np.linalg.norm(vector)))
        sizes.append(math.sqrt(float(np.linalg.norm(vector))))
        if sizes[-1] <= sizes[-2] * (1.0 + _SAME):
            return sizes[-1]
    last = len(matrix) - 1
    (square,) = _eigh(matrix.T @ matrix, eigvals_only=True, subset_by_index=[last, last], overwrite_a=True)
    return math.sqrt(float(square))


def _above(value: float, offset: float) -> float:
    return max(value * (1.0 + _PEAK), abs(offset) * (1.0 + _LEAST))


def _raised_by_values(system: OpenLoop, offset: float, known: _Peak, crossed: _Crossed) -> _Peak:
    """Return the angle over a period and the value of the largest singular value of offset - T, if one is larger."""
    eye, period = offset * np.eye(system.per_period), system.map.period
    ends, more = np.array([0.0, math.pi]), np.abs(np.angle(system.poles))
    best = known
    while found := crossed(_above(best[1], offset)):
        marks = np.unique(np.abs([*ends, *found]))
        angles = np.unique([*ends, *(0.5 * (marks[:-1] + marks[1:])), *more])
        sizes = np.linalg.norm(eye - system.complementary(angles / period), 2, axis=(1, 2))
        place, before = int(np.argmax(sizes)), best
        best = max(best, (float(angles[place]), float(sizes[place])), key=_height)
        if best[1] <= before[1] * (1.0 + _PEAK):
            break
        more = more[:0]
    return best


def _raised_by_levels(system: OpenLoop, offset: float, known: _Peak, crossed: _Crossed) -> _Peak:
    """Return the same by bisection of the level, without a singular value."""
    low = _above(known[1], offset)
    found = crossed(low)
    if not found:
        return known
    high = 2.0 * low
    while further := crossed(high):
        found, low, high = further, high, 2.0 * high
    while high > low * (1.0 + _PEAK):
        middle = math.sqrt(low * high)
        further = crossed(middle)
        found, low, high = (further, middle, high) if further else (found, low, middle)
    first, *others = sorted({abs(angle) for angle in found})
    if others:
        return 0.5 * (first + others[0]), low
    return (0.0 if first < 0.5 * math.pi else math.pi), low


def stable_gains(system: OpenLoop) -> tuple[FactorInterval, ...]:
    """Return the intervals of factors at the wire with which the loop is stable; up to a billion counts as any."""
    last = math.log(LARGEST_FACTOR)
    places = np.linspace(-last, last, round(2.0 * last * _FACTORS / math.log(10.0)) + 1)
    intervals = stable_intervals(lambda x: system.growths(np.exp(x)), places)
    return tuple(
        (0.0 if low == -last else math.exp(low), math.inf if high == last else math.exp(high))
        for low, high in intervals
    )


def _critical_turn(system: OpenLoop) -> float | None:
    """Return the least turn at the wire that makes a stable loop unstable."""
    places = np.linspace(0.0, math.pi, _TURNS + 1)
    _, turn = next(stable_intervals(lambda x: system.growths(np.exp(-1j * x)), places), (0.0, 0.0))
    return None if turn == math.pi else turn


def _phase_crossovers(system: OpenLoop, response: Samples) -> list[float]:
    """Return where the response is real and negative: every other time that it is real, as it is at half the rate."""
    ends = [math.pi / system.sample]
    found = crossings(response.up_to(ends[0] * (1.0 - 1e-9)), lambda values: values.imag, 2 * MOST_CROSSOVERS) + ends
    return [v for v, answer in zip(found, system.response(np.array(found)), strict=True) if answer.real < 0.0]


def _bandwidth(closed: Samples) -> float | None:
    """Return where the closed loop, at the frequency of what goes in, first falls 3 dB below its value at rest.

    It is None where it does not, or is zero at rest.
    """
    at_rest = float(abs(closed.values[0]))
    if at_rest <= AT_REST * float(np.max(np.abs(closed.values))):
        return None
    fallen = crossings(closed, lambda values: np.abs(values) / at_rest - math.sqrt(0.5), 1)
    return fallen[0] / (2.0 * math.pi) if fallen else None
