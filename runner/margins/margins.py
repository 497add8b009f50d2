"""Stability margins of the loops of a graph, from its exact linearisation.

The verdict comes from the closed-loop poles alone. Of a stable loop:

- gain margin: the factors next to 1, above and below, which put a pole on the unit circle, -1 / L where L is real;
- phase margin: the least phase, of either sign, that does, |arg(-L)| where |L| = 1; delay margin: the least delay,
  (arg(-L) modulo 2 pi) / w;
- sensitivity peak Ms = max |S|, S = 1 / (1 + L); disk margin 2 / max |S - T| (Seiler, Packard and Gahinet, IEEE
  Control Systems 40, 2020, 78), which holds for gain and phase together;
- bandwidth: where |T| falls by 3 dB, T = L / (1 + L).

Where a loop has several values of its wire in a common period, no single L exists: gain and phase margin are then the
factor and the turn at the wire which put a pole of the closed period on the unit circle, the delay margin is the number
of whole samples before the first that does, or 64; S and T are matrices, their size is the largest singular value.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from proofmass.runner.margins.frequencies import Samples, crossings, grid, highest, zero_between
from proofmass.runner.margins.open_loop import Complex, OpenLoop
from proofmass.runner.margins.period_map import Array

LARGEST_FACTOR, LARGEST_DELAY = 1.0e9, 64  # of margins found by trying: factor, samples
_RATIO, _TURN = 1.05, math.radians(1.0)  # steps of the trial


@dataclass(frozen=True)
class Margins:
    """The margins of one loop; what does not exist is None: a margin without limit, any of an unstable loop."""

    loop: str
    open_at: str
    stable: bool
    poles: Complex  # of the closed loop over its period, the slowest first
    period: float  # s
    sample: float  # s, of the wire
    gain_margin: float | None  # factor above 1
    gain_reduction: float | None  # factor below 1 which makes the loop unstable
    phase_margin: float | None  # rad
    delay_margin: float | None  # s
    disk_margin: float | None
    sensitivity_peak: float | None
    sensitivity_peak_frequency: float | None  # Hz
    bandwidth: float | None  # Hz
    gain_crossovers: tuple[float, ...]  # Hz, where |L| = 1
    phase_crossovers: tuple[float, ...]  # Hz, where L < 0
    system: OpenLoop

    def as_data(self) -> dict[str, Any]:
        """The numbers as plain data, in the units of their names."""
        return {
            "loop": self.loop,
            "open_at": self.open_at,
            "stable": self.stable,
            "gain_margin_db": decibels(self.gain_margin),
            "gain_reduction_db": decibels(self.gain_reduction),
            "phase_margin_deg": None if self.phase_margin is None else math.degrees(self.phase_margin),
            "delay_margin_s": self.delay_margin,
            "delay_margin_samples": None if self.delay_margin is None else self.delay_margin / self.sample,
            "disk_margin": self.disk_margin,
            "sensitivity_peak_db": decibels(self.sensitivity_peak),
            "sensitivity_peak_frequency_hz": self.sensitivity_peak_frequency,
            "bandwidth_hz": self.bandwidth,
            "gain_crossovers_hz": list(self.gain_crossovers),
            "phase_crossovers_hz": list(self.phase_crossovers),
            "period_s": self.period,
            "sample_s": self.sample,
            "poles": [[pole.real, pole.imag] for pole in self.poles],
        }


def decibels(factor: float | None) -> float | None:
    """20 log10 of a factor."""
    return None if factor is None else 20.0 * math.log10(factor)


def margins_of(system: OpenLoop, loop: str, open_at: str) -> Margins:
    """All margins of an open loop."""
    w = grid(system)
    response = Samples.on(w, system.response)
    crossover = crossings(response, lambda values: np.abs(values) - 1.0)
    turned = _phase_crossovers(system, response)
    stable = bool(np.all(np.abs(system.poles) < 1.0))
    up = down = phase = delay = disk = peak = at = band = None
    if stable:
        single = system.per_period == 1
        up, down = _gain_limits(system, turned) if single else _gain_limits_by_trial(system)
        phase, delay = _phase_limits(system, crossover) if single else _phase_limits_by_trial(system)
        closed, eye = Samples.on(np.array([0.0, *w]), system.complementary), np.eye(system.per_period)
        at, peak = highest(closed, lambda values: _size(eye - values))
        disk = 1.0 / highest(closed, lambda values: _size(0.5 * eye - values))[1]
        band = _bandwidth(closed)
    hertz = 1.0 / (2.0 * math.pi)
    return Margins(
        loop=loop,
        open_at=open_at,
        stable=stable,
        poles=system.poles,
        period=system.map.period,
        sample=system.sample,
        gain_margin=up,
        gain_reduction=down,
        phase_margin=phase,
        delay_margin=delay,
        disk_margin=disk,
        sensitivity_peak=peak,
        sensitivity_peak_frequency=None if at is None else at * hertz,
        bandwidth=None if band is None else band * hertz,
        gain_crossovers=tuple(v * hertz for v in crossover),
        phase_crossovers=tuple(v * hertz for v in turned),
        system=system,
    )


def _phase_crossovers(system: OpenLoop, response: Samples) -> list[float]:
    """Where the response is real and negative; at half the rate of the wire it is real by nature."""
    ends = [math.pi / system.sample]
    found = crossings(response.up_to(ends[0] * (1.0 - 1e-9)), lambda values: values.imag) + ends
    return [v for v in found if system.response(v).real < 0.0]


def _gain_limits(system: OpenLoop, turned: list[float]) -> tuple[float | None, float | None]:
    """The factors nearest to 1 at which a closed-loop pole lies on the unit circle."""
    values = [float(system.response(v).real) for v in turned]
    if not np.any(np.abs(system.open_poles - 1.0) < 1e-9):
        values.append(float(system.response(0.0).real))
    factors = [-1.0 / value for value in values if 1.0 / LARGEST_FACTOR < -value < LARGEST_FACTOR]
    return min((f for f in factors if f > 1.0), default=None), max((f for f in factors if f < 1.0), default=None)


def _phase_limits(system: OpenLoop, crossover: list[float]) -> tuple[float | None, float | None]:
    """The least turn and the least delay at which a closed-loop pole lies on the unit circle."""
    lags = [(v, float(np.angle(-system.response(v)))) for v in crossover]
    phase = min((abs(lag) for _, lag in lags), default=None)
    return phase, min(((lag % (2.0 * math.pi)) / v for v, lag in lags), default=None)


def _gain_limits_by_trial(system: OpenLoop) -> tuple[float | None, float | None]:
    up = _first(lambda x: system.radius(math.exp(x)), math.log(_RATIO), math.log(LARGEST_FACTOR))
    down = _first(lambda x: system.radius(math.exp(-x)), math.log(_RATIO), math.log(LARGEST_FACTOR))
    return None if up is None else math.exp(up), None if down is None else math.exp(-down)


def _phase_limits_by_trial(system: OpenLoop) -> tuple[float | None, float]:
    phase = _first(lambda x: system.radius(complex(math.cos(x), -math.sin(x))), _TURN, math.pi)
    for samples in range(1, LARGEST_DELAY + 1):
        if _delayed_radius(system, samples) >= 1.0:
            return phase, (samples - 1) * system.sample
    return phase, LARGEST_DELAY * system.sample


def _delayed_radius(system: OpenLoop, samples: int) -> float:
    """Largest pole with the wire delayed by some of its samples: a register for each."""
    a, b, c, d = system.matrices
    n, p = len(a), system.per_period
    # What the wire brings in a period is the last entries of a queue: the registers, then what comes back.
    queue = np.vstack([np.hstack([np.zeros((samples, n)), np.eye(samples)]), np.hstack([c, np.zeros((p, samples))])])
    for row in range(p):  # u[row] = -queue[row], and what comes back in the same period may depend on it
        queue[samples + row] -= d[row, :row] @ queue[:row] if row else 0.0
    state = np.hstack([a, np.zeros((n, samples))]) - b @ queue[:p]
    return float(np.max(np.abs(np.linalg.eigvals(np.vstack([state, queue[p:]])))))


def _first(size: Callable[[float], float], step: float, last: float) -> float | None:
    """The first place beyond 0 where the size reaches 1."""
    before = 0.0
    while before < last:
        after = min(before + step, last)
        if size(after) >= 1.0:
            return zero_between(lambda x: size(x) - 1.0, before, after)
        before = after
    return None


def _size(matrices: Complex) -> Array:
    """Largest singular value of each matrix."""
    value: Array = np.abs(matrices[:, 0, 0]) if matrices.shape[-1] == 1 else np.linalg.norm(matrices, 2, axis=(1, 2))
    return value


def _bandwidth(closed: Samples) -> float | None:
    """Where the closed loop first falls by 3 dB from what it is at rest."""
    at_rest = float(_size(closed.answer(np.zeros(1)))[0])
    if at_rest == 0.0:
        return None
    fallen = crossings(closed, lambda values: _size(values) / at_rest - math.sqrt(0.5))
    return fallen[0] if fallen else None
