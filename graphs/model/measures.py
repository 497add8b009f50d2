"""Measures of a graph: signals reduced to one number each while it runs; no trace is kept for them."""

import math
from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any, NamedTuple

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, did_you_mean, shown
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
from proofmass.graphs.model.keys import MEASURE_KEYS
from proofmass.graphs.model.limits import EXPECTED_NAME, NAME
from proofmass.graphs.model.rates import read_duration

MEASURES = "measures"  # above the names of the blocks that measure
LAST = "last"
# What the block that reduces a signal is, and which of its outputs; the last value needs none.
STATISTICS: dict[str, tuple[type[Block], str] | None] = {
    "mean": (RunningStatistics, "mean"),
    "std": (RunningStatistics, "standard_deviation"),
    "rms": (RunningStatistics, "root_mean_square"),
    "mean_absolute": (MeanAbsolute, "mean_absolute"),
    "min": (RunningRange, "minimum"),
    "max": (RunningRange, "maximum"),
    "peak_to_peak": (RunningRange, "peak_to_peak"),
    LAST: None,
    "slope": (LinearTrend, "slope"),
    "percentile": (RunningPercentile, "percentile"),
    "allan_deviation": (AllanDeviation, "deviation"),
    "settling_time": (SettlingTime, "time_to_settle"),
    "tone_amplitude": (ToneMeter, "amplitude"),
    "tone_phase": (ToneMeter, "phase"),
    "band_rms": (BandMeter, "rms"),
    "density": (DensityMeter, "density"),
}
TAU = "tau"
OPTIONS = {  # all needed
    "percentile": ("percent",),
    "allan_deviation": (TAU,),
    "settling_time": ("target", "within"),
    "tone_amplitude": ("frequency",),
    "tone_phase": ("frequency",),
    "band_rms": ("low", "high"),
    "density": ("frequency", "segment"),
}
UNITS = {"settling_time": "s", "tone_phase": "rad", "slope": "({unit})/s", "density": "({unit})/sqrt(Hz)"}


class Measure(NamedTuple):
    """An output port reduced by a statistic over all its ticks from `start` seconds on."""

    signal: str
    statistic: str
    start: Fraction = Fraction(0)
    options: tuple[tuple[str, Any], ...] = ()  # parameters of the statistic as they are written; `tau` in seconds

    def averaging(self, rate: Fraction) -> int:
        """Samples in the averaging time of an Allan deviation, the nearest number; 1 for other statistics."""
        tau: Fraction = dict(self.options).get(TAU, Fraction(0))
        return max(1, round(tau * rate))

    def fewest(self, rate: Fraction) -> int:
        """Values of the signal without which there is no such measure."""
        if self.statistic == "density":
            return int(dict(self.options)["segment"])
        return 2 * self.averaging(rate) if self.statistic == "allan_deviation" else 1

    def reducer(self, unit: str, rate: Fraction) -> Block:
        """The block that reduces a signal of that unit and rate; raises `ModelError` for options that do not suit."""
        kind, _ = STATISTICS[self.statistic] or (RunningStatistics, LAST)
        values = {key: value for key, value in self.options if key != TAU}
        if kind is AllanDeviation:
            values["averaging"] = self.averaging(rate)
        return kind(skip=math.ceil(self.start * rate), unit=unit, **values)


def measure_unit(statistic: str, unit: str) -> str:
    """Unit of a measure of a signal in that unit."""
    return short_unit(UNITS.get(statistic, "{unit}").format(unit=unit))


def read_measures(table: object) -> dict[str, Measure]:
    """The table `[measures]` of a graph file, in the order of the names; raises `ModelError` with all that is wrong."""
    if not isinstance(table, Mapping):
        hint = 'write [measures] and below it bias = { signal = "adc.code", statistic = "mean" }'
        raise ModelError([_problem("must be a table", got=shown(table), hint=hint)])
    problems: list[Problem] = []
    read: dict[str, Measure] = {}
    for name, measure in table.items():
        given = _as_table(measure)
        found = list(_problems(name, given))
        problems += found
        if not found:
            options = {key: given[key] for key in OPTIONS.get(given["statistic"], ())}
            options |= {key: read_duration(value) for key, value in options.items() if key == TAU}
            start = read_duration(given.get("from", 0))
            read[name] = Measure(given["signal"], given["statistic"], start, tuple(options.items()))
    if problems:
        raise ModelError(problems)
    return dict(sorted(read.items()))


def _as_table(measure: object) -> Any:
    if isinstance(measure, Measure):
        own = {"signal": measure.signal, "statistic": measure.statistic, "from": measure.start}
        return own | dict(measure.options)
    return measure


def _problems(name: object, given: Any) -> Iterator[Problem]:
    hint = 'write bias = { signal = "adc.code", statistic = "mean", from = "0.5 s" }'
    if not isinstance(name, str) or not NAME.fullmatch(name):
        yield _problem("not a name", str(name), got=shown(name), expected=EXPECTED_NAME)
        return
    if not isinstance(given, Mapping):
        yield _problem("must be a table", name, got=shown(given), hint=hint)
        return
    for key in given:
        if key not in MEASURE_KEYS:
            near = did_you_mean(str(key), MEASURE_KEYS, "the keys")
            yield _problem("unknown key", name, str(key), got=shown(key), hint=near)
    for key in ("signal", "statistic"):
        if key not in given:
            expected = f"one of {', '.join(STATISTICS)}" if key == "statistic" else MEASURE_KEYS[key]
            yield _problem(f"has no {key}", name, expected=expected, hint=hint)
    signal, statistic = given.get("signal", "a.b"), given.get("statistic", LAST)
    if not isinstance(signal, str) or not all(NAME.fullmatch(part) for part in signal.split(".")) or "." not in signal:
        yield _problem("not an output", name, "signal", got=shown(signal), hint='write signal = "block.output"')
    if not isinstance(statistic, str) or statistic not in STATISTICS:
        near = did_you_mean(str(statistic), STATISTICS, "the statistics")
        yield _problem("there is no such statistic", name, "statistic", got=shown(statistic), hint=near)
        return
    wanted = OPTIONS.get(statistic, ())
    for key in wanted:
        if key not in given:
            yield _problem(f"{statistic} needs {key}", name, expected=MEASURE_KEYS[key])
    for key in set(given) & {key for keys in OPTIONS.values() for key in keys} - set(wanted):
        yield _problem(f"{statistic} has no {key}", name, key, got=shown(given[key]), hint="leave it out")
    for key in ("from", TAU):
        try:
            read_duration(given.get(key, 0))
        except Refusal as error:
            yield _problem(str(error), name, key, got=shown(given[key]), hint=error.hint)


def _problem(message: str, *path: str, **more: Any) -> Problem:
    path = (MEASURES, *path)
    return Problem(message=message, key=".".join(path), path=path, **more)
