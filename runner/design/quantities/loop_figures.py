"""Figures of a loop with their exact derivatives by parameters.

A margin lies at a frequency at which L meets a condition: Im L = 0, |L| = 1, |T| = |T(0)| / sqrt 2.
If a parameter moves L by dL, the frequency moves by dw so that the condition still holds, and the
figure by what both do to it. At a peak dw does not count. Where a period has several values of the
wire, a margin puts a closed-loop pole on the unit circle, and a peak is a singular value. dL = c
(zI - A)^-1 (dA (zI - A)^-1 b + db) + dc (zI - A)^-1 b + dd.
"""

import cmath
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.step import step_response
from proofmass.runner.analysis.linearisation.wire_response import WireResponse
from proofmass.runner.analysis.margins.frequencies import sweep
from proofmass.runner.analysis.margins.lifted import closed_samples, largest
from proofmass.runner.analysis.margins.margins import Margins, margins_at
from proofmass.runner.analysis.margins.sensitivity import by_gain, by_turn, closed_slope
from proofmass.runner.analysis.margins.step import closed_loop
from proofmass.runner.host.arrays import Complex

_DECIBELS = 20.0 / math.log(10.0)
_AT_REST = 1e-6  # of the bandwidth: a frequency that counts as rest
_STEP = 1e-5  # of a parameter, for differences of exact matrices


class Reading(NamedTuple):
    """A value and its derivatives by parameters; infinite where there is no limit."""

    value: float
    slopes: Mapping[str, float]


class NoValue(NamedTuple):
    """Reason why a quantity has no value."""

    reason: str
    unstable: bool = False  # a loop is


def read_figure(margins: Margins, system: OpenLoop, figure: str, parameters: Mapping[str, float]) -> Reading:
    """Return a figure of a stable loop; `system` has derivatives of its matrices by parameters."""
    value = value_of_figure(margins, figure)
    if not math.isfinite(value):
        return Reading(value, {})
    names = [name for name in parameters if name in system.map.slopes]
    slope: SlopeByParameter | None = None
    if system.per_period > 1 and figure in _LIFTED:
        slope = _LIFTED[figure](system, margins)
    elif system.per_period == 1 and figure in _EXACT:
        slope = _EXACT[figure](margins, _Response(system))
    if slope is not None:
        return Reading(value, {name: slope(name) for name in names})

    def along(name: str, step: float) -> float:
        margins = margins_at(replace(system, map=system.map.along(name, step)), "", "")
        return value_of_figure(margins, figure) if margins.stable else math.nan

    return Reading(value, differences(along, {name: parameters[name] for name in names}))


def value_of_figure(margins: Margins, figure: str) -> float:
    """Return a figure of a stable loop in its unit; infinite where there is no limit."""
    if figure in ("overshoot", "settling_time"):
        return step_figures(margins)[figure]
    return margins.value(figure)


class _Response:
    """L of a loop with one value of its wire in a period, its frequency and parameters."""

    def __init__(self, system: OpenLoop) -> None:
        self.system, self._at = system, dict[float, tuple[complex, complex, Complex, Complex]]()
        self.scale = 1.0 if system.continuous else system.map.period

    def at(self, w: float) -> tuple[complex, complex, Complex, Complex]:
        """Return L, its derivative by frequency, and vectors left and right of a change of A."""
        if w not in self._at:
            a, b, c, d = self.system.matrices
            z = 1j * w if self.system.continuous else cmath.exp(1j * w * self.scale)
            turning = 1j if self.system.continuous else 1j * self.scale * z
            pencil = z * np.eye(len(a)) - a
            right = np.linalg.solve(pencil, b.astype(complex))
            left = np.linalg.solve(pencil.T, c.T.astype(complex)).T
            value = complex((c @ right + d)[0, 0])
            by_w = complex((-left @ right * turning)[0, 0])
            vectors: tuple[Complex, Complex] = np.asarray(left, complex), np.asarray(right, complex)
            self._at[w] = value, by_w, *vectors
        return self._at[w]

    def by(self, parameter: str, w: float) -> complex:
        """Return the derivative of L by a parameter."""
        _, _, left, right = self.at(w)
        da, db, dc, dd = self.system.slopes(parameter)
        return complex((left @ (da @ right + db) + dc @ right + dd)[0, 0])


SlopeByParameter = Callable[[str], float]


def _gain(margins: Margins, loop: _Response) -> SlopeByParameter | None:
    factor = margins.nearest_gain
    assert factor is not None
    crossovers = zip(margins.phase_crossovers, margins.phase_crossover_gains, strict=True)
    near = [f for f, size in crossovers if math.isclose(size * factor, 1.0, rel_tol=1e-6)]
    if not near:
        return None
    w = 2.0 * math.pi * near[0]
    value, by_w, _, _ = loop.at(w)
    sign = 1.0 if factor > 1.0 else -1.0

    def slope(parameter: str) -> float:
        moved = loop.by(parameter, w)
        dw = -moved.imag / by_w.imag if abs(by_w.imag) > 1e-300 else 0.0
        return -sign * _DECIBELS * (moved + by_w * dw).real / value.real

    return slope


def _crossover(loop: _Response, w: float) -> Callable[[str], tuple[float, float, float]]:
    """Return the phase that is left at a gain crossover, and what a parameter does to it and to the frequency."""
    value, by_w, _, _ = loop.at(w)
    lag = cmath.phase(-value)

    def moves(parameter: str) -> tuple[float, float, float]:
        moved, turned = loop.by(parameter, w) / value, by_w / value
        dw = -moved.real / turned.real
        return lag, (moved + turned * dw).imag, dw

    return moves


def _phase(margins: Margins, loop: _Response) -> SlopeByParameter | None:
    if margins.phase_margin_frequency is None:
        return None
    moves = _crossover(loop, 2.0 * math.pi * margins.phase_margin_frequency)

    def slope(parameter: str) -> float:
        lag, change, _ = moves(parameter)
        return math.degrees(math.copysign(change, lag * change))

    return slope


def _delay(margins: Margins, loop: _Response) -> SlopeByParameter | None:
    if margins.delay_margin_frequency in (None, math.inf) or margins.delay_margin is None:
        return None
    if math.isclose(2.0 * margins.delay_margin_frequency * margins.sample, 1.0):
        return lambda parameter: 0.0  # a whole sample
    w, late = 2.0 * math.pi * margins.delay_margin_frequency, margins.delay_margin
    moves = _crossover(loop, w)

    def slope(parameter: str) -> float:
        _, change, dw = moves(parameter)
        return (change - late * dw) / w

    return slope


def _peak(margins: Margins, loop: _Response) -> SlopeByParameter | None:
    if margins.sensitivity_peak_frequency in (None, 0.0, math.inf):
        return None
    w = 2.0 * math.pi * margins.sensitivity_peak_frequency
    value, _, _, _ = loop.at(w)
    return lambda parameter: -_DECIBELS * (loop.by(parameter, w) / (1.0 + value)).real


def _bandwidth(margins: Margins, loop: _Response) -> SlopeByParameter | None:
    if margins.bandwidth is None:
        return None
    w = 2.0 * math.pi * margins.bandwidth
    rest = _AT_REST * w
    (value, by_w, _, _), (low, _, _, _) = loop.at(w), loop.at(rest)
    part, part_low = 1.0 / (value * (1.0 + value)), 1.0 / (low * (1.0 + low))  # of T = L / (1 + L), relative
    falling = (by_w * part).real

    def slope(parameter: str) -> float:
        change = (loop.by(parameter, w) * part).real - (loop.by(parameter, rest) * part_low).real
        return -change / falling / (2.0 * math.pi)

    return slope


_EXACT: Mapping[str, Callable[[Margins, _Response], SlopeByParameter | None]] = {
    "gain_margin": _gain,
    "phase_margin": _phase,
    "delay_margin": _delay,
    "sensitivity_peak": _peak,
    "bandwidth": _bandwidth,
}


def _lifted_peak(system: OpenLoop, margins: Margins) -> SlopeByParameter:
    assert margins.sensitivity_peak_frequency is not None
    size, slope = _singular_value(system, 1.0, margins.sensitivity_peak_frequency)
    return lambda parameter: _DECIBELS * slope(parameter) / size


def _lifted_disk(system: OpenLoop, margins: Margins) -> SlopeByParameter:
    at, _ = largest(system, 0.5, closed_samples(system, sweep(system)))
    size, slope = _singular_value(system, 0.5, at / (2.0 * math.pi))
    return lambda parameter: -slope(parameter) / size**2


def _singular_value(system: OpenLoop, offset: float, frequency: float) -> tuple[float, SlopeByParameter]:
    """Return the largest |offset - T| at a frequency, u* (offset - T) v, and its slopes: -u* S dL S v."""
    a, b, c, d = system.matrices
    eye, w = np.eye(len(d)), np.array([2.0 * math.pi * frequency])
    (lifted,), z = system.lifted(w), cmath.exp(1j * w[0] * system.map.period)
    sensitivity = np.linalg.inv(eye + lifted)
    left, sizes, right = np.linalg.svd(sensitivity + (offset - 1.0) * eye)
    into, out = sensitivity @ right[0].conj(), left[:, 0].conj() @ sensitivity
    pencil = z * np.eye(len(a)) - a
    moved, read = np.linalg.solve(pencil, b @ into), np.linalg.solve(pencil.T, out @ c)

    def slope(parameter: str) -> float:
        da, db, dc, dd = system.slopes(parameter)
        return -float((read @ (da @ moved + db @ into) + out @ (dc @ moved + dd @ into)).real)

    return float(sizes[0]), slope


_LIFTED: Mapping[str, Callable[[OpenLoop, Margins], SlopeByParameter]] = {
    "gain_margin": by_gain,
    "phase_margin": by_turn,
    "delay_margin": lambda system, margins: lambda parameter: 0.0,  # of whole values
    "sensitivity_peak": _lifted_peak,
    "disk_margin": _lifted_disk,
}


def differences(along: Callable[[str, float], float], parameters: Mapping[str, float]) -> dict[str, float]:
    """Return derivatives by central differences of what a step of a parameter makes of a value; 0 where it has none."""
    slopes = {}
    for name, value in parameters.items():
        step = _STEP * (abs(value) or 1.0)
        ends = [along(name, side * step) for side in (1.0, -1.0)]
        slopes[name] = (ends[0] - ends[1]) / (2.0 * step) if all(map(math.isfinite, ends)) else 0.0
    return slopes


def growth(system: OpenLoop, parameters: Sequence[str]) -> Reading:
    """Return the logarithm of the largest closed-loop pole: negative where the loop is stable."""
    closed = np.real(system.closed())
    poles, vectors = np.linalg.eig(closed)
    worst = int(np.argmax(np.real(poles) if system.continuous else np.abs(poles)))
    pole, left = complex(poles[worst]), np.linalg.pinv(vectors)[worst]
    slopes = {}
    for name in parameters:
        if name in system.map.slopes:
            moved = complex(left @ closed_slope(system, 1.0, name) @ vectors[:, worst])
            slopes[name] = moved.real if system.continuous else (moved / pole).real
    return Reading(pole.real if system.continuous else math.log(abs(pole) + 1e-300), slopes)


def step_figures(margins: Margins) -> dict[str, float]:
    """Return the overshoot in per cent and the settling time of T within 2 % in seconds, of the mean over a period.

    They are infinite where T is zero at rest. Modes that last, which no figure sees, are left out.
    """
    of = closed_loop(margins)
    a, b, c, d = of.matrices
    found = step_response(WireResponse((a, b, c.mean(axis=0, keepdims=True), d.mean(axis=0, keepdims=True)), of.period))
    over, settling = (None, None) if found is None else (found.figures.overshoot, found.figures.settling)
    return {
        "overshoot": math.inf if over is None else 100.0 * over,
        "settling_time": math.inf if settling is None else settling,
    }
