"""The figures of a loop: margins, peaks, crossovers."""

import math
from dataclasses import dataclass
from typing import Any

from proofmass.graphs.model.loops import REQUIREMENTS
from proofmass.runner.output.json_text import finite

LARGEST_FACTOR = 1.0e9  # of gain margins; beyond it a loop counts as unlimited
FactorInterval = tuple[float, float]


@dataclass(frozen=True, eq=False, kw_only=True)
class Figures:
    """The figures; None for a margin without limit, and for any margin of a loop that is not stable.

    What a continuous loop reaches in the limit only is at an infinite frequency, which is null in
    JSON.
    """

    gain_margin: float | None = None  # factor above 1
    gain_margin_frequency: float | None = None  # Hz, of the oscillation there; None where only the factor is known
    gain_reduction: float | None = None  # factor below 1 which makes the loop unstable
    phase_margin: float | None = None  # rad
    phase_margin_frequency: float | None = None  # Hz
    delay_margin: float | None = None  # s
    delay_margin_frequency: float | None = None  # Hz
    disk_margin: float | None = None  # 2 / max |S - T|, of gain and phase together
    sensitivity_peak: float | None = None  # max |S|, a factor
    sensitivity_peak_frequency: float | None = None  # Hz
    bandwidth: float | None = None  # Hz
    distance: float | None = None  # the least |1 + L|; None where L is not a single number
    stable_gains: tuple[FactorInterval, ...] = ()  # all intervals of stable factors
    gain_crossovers: tuple[float, ...] = ()  # Hz, where |L| = 1
    gain_crossover_phases: tuple[float, ...] = ()  # rad, arg(-L) there: the phase left until -1
    phase_crossovers: tuple[float, ...] = ()  # Hz, where L < 0
    phase_crossover_gains: tuple[float, ...] = ()  # |L| there

    @property
    def nearest_gain(self) -> float | None:
        """The factor next to 1, above or below, with which the loop is not stable; None where all leave it stable."""
        factors = [limit for limit in (self.gain_margin, self.gain_reduction) if limit and math.isfinite(limit)]
        return min(factors, key=lambda factor: abs(math.log(factor)), default=None)

    @property
    def least_gain_margin(self) -> float:
        """Decibels by which the gain may change, to the nearer side; infinite without limit."""
        factor = self.nearest_gain
        return math.inf if factor is None else 20.0 * abs(math.log10(factor))

    def value(self, name: str) -> float:
        """Return a figure of a stable loop in dB, deg, s, Hz or as it is; infinite where there is no limit."""
        value = {
            "gain_margin": self.least_gain_margin,
            "phase_margin": self.phase_margin and math.degrees(self.phase_margin),
            "delay_margin": self.delay_margin,
            "disk_margin": self.disk_margin,
            "sensitivity_peak": decibels(self.sensitivity_peak),
            "bandwidth": self.bandwidth,
        }[name]
        return math.inf if value is None else float(value)

    def required(self) -> dict[str, float]:
        """Return what a loop may require of its margins, in the units of that."""
        return {name: self.value(name) for name in REQUIREMENTS}

    def as_data(self) -> dict[str, Any]:
        """Return the numbers as plain data, in the units that their names say."""
        return {
            "gain_margin_db": decibels(self.gain_margin),
            "gain_margin_frequency_hz": finite(self.gain_margin_frequency),
            "gain_reduction_db": decibels(self.gain_reduction),
            "phase_margin_deg": None if self.phase_margin is None else math.degrees(self.phase_margin),
            "phase_margin_frequency_hz": self.phase_margin_frequency,
            "delay_margin_s": self.delay_margin,
            "delay_margin_frequency_hz": finite(self.delay_margin_frequency),
            "disk_margin": self.disk_margin,
            "sensitivity_peak_db": decibels(self.sensitivity_peak),
            "sensitivity_peak_frequency_hz": finite(self.sensitivity_peak_frequency),
            "bandwidth_hz": self.bandwidth,
            "distance": self.distance,
            "stable_gains": [[low, None if math.isinf(high) else high] for low, high in self.stable_gains],
            "gain_crossovers_hz": list(self.gain_crossovers),
            "gain_crossover_phases_deg": [math.degrees(phase) for phase in self.gain_crossover_phases],
            "phase_crossovers_hz": list(self.phase_crossovers),
            "phase_crossover_gains_db": [decibels(gain) for gain in self.phase_crossover_gains],
        }


def decibels(factor: float | None) -> float | None:
    """Return 20 log10 of a factor."""
    return None if factor is None else 20.0 * math.log10(factor)
