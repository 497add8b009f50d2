"""Statistics of measures, a row each: its block, its unit and the options that it needs."""

import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from types import MappingProxyType
from typing import Any

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.units import short_unit
from proofmass.blocks.statistics.allan_deviation import AllanDeviation
from proofmass.blocks.statistics.band_meter import BandMeter
from proofmass.blocks.statistics.density_meter import DensityMeter
from proofmass.blocks.statistics.linear_trend import LinearTrend
from proofmass.blocks.statistics.mean_absolute import MeanAbsolute
from proofmass.blocks.statistics.running_percentile import RunningPercentile
from proofmass.blocks.statistics.running_range import RunningRange
from proofmass.blocks.statistics.running_statistics import RunningStatistics
from proofmass.blocks.statistics.settling_time import SettlingTime
from proofmass.blocks.statistics.tone_meter import ToneMeter
from proofmass.graphs.model.rates import Clock


@dataclass(frozen=True)
class Option:
    """A key that a measure of this statistic must have: a parameter of its block, or a time."""

    doc: str
    example: str  # its value, as it is written in a file
    samples: str = ""  # for a time: the parameter of the block that takes it as a number of samples
    least: int = 1  # for a time: how many such times a run must last
    spectral: bool = False  # whether it is a frequency, of which a signal has those up to half its rate


@dataclass(frozen=True)
class Statistic:
    """The block that reduces a signal, and the output that is read at the end; without a block, the last value."""

    block: type[Block] | None = None
    output: str = ""
    unit: str = "{unit}"  # of the measure, for a signal in that unit
    options: Mapping[str, Option] = field(default_factory=dict)
    least: int = 1  # samples, below which it has no value
    within: Callable[[Any, Any], bool] = operator.le  # how its frequencies lie to half the rate
    defined: str = ""  # output of the block that is true where it has a value; without it, always
    delay: Callable[[Clock, Fraction], Fraction] | None = None  # the block's `delay`, from the clock and `from`

    @property
    def times(self) -> dict[str, Option]:
        """The options that are times."""
        return {key: option for key, option in self.options.items() if option.samples}

    def unit_for(self, unit: str) -> str:
        """Return the unit of a measure of a signal in `unit`."""
        return short_unit(self.unit.format(unit=unit))


def _to_the_first_tick(clock: Clock, start: Fraction) -> Fraction:
    return clock.offset


def _to_the_first_sample(clock: Clock, start: Fraction) -> Fraction:
    return clock.time(clock.first(start)) - start


LAST = "last"
_PERCENT = Option("For a percentile: how many per cent of the values lie below it.", "99")
_TAU = Option('For an Allan deviation: the averaging time, "1 s".', '"1 s"', samples="averaging", least=2)
_TARGET = Option("For a settling time: where the signal settles.", "1.0")
_WITHIN = Option("For a settling time: how far from the target it may be.", "0.01")
_FREQUENCY = Option('For a tone or a density: its frequency, "100 Hz".', '"100 Hz"', spectral=True)
_LOW = Option('For the rms in a band: where the band begins, "1 Hz"; 0 keeps the mean.', '"1 Hz"', spectral=True)
_HIGH = Option('For the rms in a band: where the band ends, "100 Hz".', '"100 Hz"', spectral=True)
_SEGMENT = Option('For a density: how long a segment is, "1 s".', '"1 s"', samples="segment")
STATISTICS: Mapping[str, Statistic] = MappingProxyType(
    {
        "mean": Statistic(RunningStatistics, "mean"),
        "std": Statistic(RunningStatistics, "standard_deviation", least=2),
        "rms": Statistic(RunningStatistics, "root_mean_square"),
        "mean_absolute": Statistic(MeanAbsolute, "mean_absolute"),
        "min": Statistic(RunningRange, "minimum"),
        "max": Statistic(RunningRange, "maximum"),
        "peak_to_peak": Statistic(RunningRange, "peak_to_peak"),
        LAST: Statistic(),
        "slope": Statistic(LinearTrend, "slope", unit="({unit})/s", least=2),
        "percentile": Statistic(RunningPercentile, "percentile", options={"percent": _PERCENT}),
        "allan_deviation": Statistic(AllanDeviation, "deviation", options={"tau": _TAU}),
        "settling_time": Statistic(
            SettlingTime,
            "time_to_settle",
            unit="s",
            options={"target": _TARGET, "within": _WITHIN},
            defined="settled",
            delay=_to_the_first_sample,
        ),
        "tone_amplitude": Statistic(
            ToneMeter,
            "amplitude",
            options={"frequency": _FREQUENCY},
            least=3,
            within=operator.lt,
            delay=_to_the_first_tick,
        ),
        "tone_phase": Statistic(
            ToneMeter,
            "phase",
            unit="rad",
            options={"frequency": _FREQUENCY},
            least=3,
            within=operator.lt,
            delay=_to_the_first_tick,
        ),
        "band_rms": Statistic(BandMeter, "rms", options={"low": _LOW, "high": _HIGH}),
        "density": Statistic(
            DensityMeter,
            "density",
            unit="({unit})/sqrt(Hz)",
            options={"frequency": _FREQUENCY, "segment": _SEGMENT},
        ),
    }
)
ELSEWHERE: Mapping[str, tuple[str, ...]] = {  # a statistic, and what other tools call it
    "mean": ("average", "avg", "expectation"),
    "std": ("sigma", "stddev", "standard_deviation", "deviation", "noise"),
    "rms": ("root_mean_square", "quadratic_mean"),
    "mean_absolute": ("mav", "mean_abs", "mae"),
    "min": ("minimum", "lowest"),
    "max": ("maximum", "highest", "peak"),
    "peak_to_peak": ("p2p", "ptp", "pk_pk", "pp", "range"),
    LAST: ("final", "end"),
    "slope": ("drift", "trend", "ramp"),
    "percentile": ("median", "quantile"),
    "allan_deviation": ("adev", "allan"),
    "settling_time": ("settling", "settle"),
    "tone_amplitude": ("amplitude", "tone"),
    "tone_phase": ("phase",),
    "density": ("psd", "asd"),
}
OPTIONS = {key: option for statistic in STATISTICS.values() for key, option in statistic.options.items()}
TIMES = frozenset(key for key, option in OPTIONS.items() if option.samples)
