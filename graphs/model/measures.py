"""Measures of a graph: signals reduced to a number while it runs; no trace is kept."""

from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any, NamedTuple

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, did_you_mean, problems_of_table, shown
from proofmass.blocks.declaration.unit_expressions import unit
from proofmass.blocks.declaration.units import convertible
from proofmass.blocks.statistics.last_value import LastValue
from proofmass.graphs.model.hints import key_hint
from proofmass.graphs.model.keys import OWN_MEASURE_KEYS
from proofmass.graphs.model.limits import EXPECTED_NAME, NAME
from proofmass.graphs.model.rates import Clock, read_duration, write_seconds
from proofmass.graphs.model.statistics import ELSEWHERE, LAST, OPTIONS, STATISTICS, TIMES

MEASURES = "measures"  # path of the blocks that measure
_problem = problems_of_table(MEASURES)
MEASURE_TIMES = TIMES | {"from", "until"}
MEASURE_KEYS = OWN_MEASURE_KEYS | {key: option.doc for key, option in OPTIONS.items()}


class Measure(NamedTuple):
    """An output port reduced by a statistic over its ticks from `start` seconds on, until `until` where it is said."""

    signal: str
    statistic: str
    start: Fraction = Fraction(0)
    options: tuple[tuple[str, Any], ...] = ()  # of the statistic, as written; times in seconds
    until: Fraction | None = None
    unit: str = ""  # in which tables show it, such as "deg/h"; its value is in that of the signal

    @property
    def block(self) -> type[Block] | None:
        """The kind of block that reduces the signal, if the measure takes one."""
        return LastValue if self.until is not None and self.statistic == LAST else STATISTICS[self.statistic].block

    @property
    def output(self) -> str:
        """The output of that block which is the measure."""
        return STATISTICS[self.statistic].output or "value"

    def end(self, clock: Clock) -> int:
        """The first tick that no longer counts; 0 where there is none."""
        return 0 if self.until is None else clock.first(self.until)

    def reducer(self, unit: str, clock: Clock) -> Block | None:
        """The block that reduces a signal of that unit and clock, if it takes one.

        Raises `ModelError` for options that do not suit.
        """
        block = self.block
        if block is None:
            return None
        if block is LastValue:
            return LastValue(until=self.end(clock), unit=unit)
        values: dict[str, Any] = {key: value for key, value in self.options if key not in TIMES}
        values |= {"until": self.end(clock)} if self.until is not None else {}
        delay = STATISTICS[self.statistic].delay
        values |= {"delay": float(delay(clock, self.start))} if delay else {}
        return block(skip=clock.first(self.start), unit=unit, **values, **self._in_samples(clock.rate))

    def least(self, rate: Fraction) -> int:
        """Least number of samples for this measure."""
        counts = self._in_samples(rate)
        statistic = STATISTICS[self.statistic]
        return max(
            (option.least * counts[option.samples] for option in statistic.times.values()), default=statistic.least
        )

    def _in_samples(self, rate: Fraction) -> dict[str, int]:
        """Parameters of the block that are times, each as the nearest number of samples."""
        times = ((OPTIONS[key].samples, value) for key, value in self.options if key in TIMES)
        return {parameter: max(1, round(value * rate)) for parameter, value in times}


def read_measures(table: object) -> dict[str, Measure]:
    """The table `[measures]` of a graph file, in the order of the names; raises `ModelError` with all that is wrong."""
    if not isinstance(table, Mapping):
        hint = 'write [measures] and below it bias = { signal = "adc.code", statistic = "mean" }'
        raise _problem("must be a table", got=shown(table), hint=hint).error
    problems: list[Problem] = []
    read: dict[str, Measure] = {}
    for name, measure in table.items():
        entries = as_table(measure)
        wrong = list(_problems(name, entries))
        problems += wrong
        if not wrong:
            options = {key: entries[key] for key in STATISTICS[entries["statistic"]].options}
            options |= {key: read_duration(value) for key, value in options.items() if key in TIMES}
            start = read_duration(entries.get("from", 0))
            until = read_duration(entries["until"]) if "until" in entries else None
            of = entries["signal"], entries["statistic"], start
            read[name] = Measure(*of, tuple(options.items()), until, entries.get("unit", ""))
    if problems:
        raise ModelError(problems)
    return dict(sorted(read.items()))


def with_entries(measures: Mapping[str, Measure], entries: Mapping[str, Mapping[str, Any]]) -> dict[str, Measure]:
    """Return measures with other values of some keys, by their names; raises `ModelError`."""
    return read_measures({name: as_table(measure) | entries.get(name, {}) for name, measure in measures.items()})


def read_display_unit(text: object) -> str:
    """Return the unit in which a signal or measure is shown, or an empty text; raises `Refusal`."""
    if not isinstance(text, str):
        raise Refusal("must be a text", 'write unit = "deg/h"')
    if text:
        unit(text)
    return text


def bad_display_unit(text: str, of: str, key: str, path: tuple[str, ...]) -> Iterator[Problem]:
    """Yield why what is measured in the unit `of` cannot be shown in another."""
    if text and not convertible(of, text):
        hint = f"write a unit of the same kind as {of}, or leave it out"
        message = f"cannot be shown in {text}: it is in {of}"
        yield Problem(message=message, key=key, got=shown(text), hint=hint, path=path)


def as_table(measure: object) -> Any:
    """Return the entries of a measure as in a graph file, times in seconds; what is no measure stays."""
    if isinstance(measure, Measure):
        own: dict[str, Any] = {"signal": measure.signal, "statistic": measure.statistic}
        own |= {"from": measure.start} if measure.start else {}
        own |= {"until": measure.until} if measure.until is not None else {}
        own |= {"unit": measure.unit} if measure.unit else {}
        return own | dict(measure.options)
    return measure


def _problems(name: object, table: Any) -> Iterator[Problem]:
    hint = 'write bias = { signal = "adc.code", statistic = "mean", from = "0.5 s" }'
    if not isinstance(name, str) or not NAME.fullmatch(name):
        yield _problem("not a name", str(name), got=shown(name), expected=EXPECTED_NAME)
        return
    if not isinstance(table, Mapping):
        yield _problem("must be a table", name, got=shown(table), hint=hint)
        return
    for key in table:
        if key not in MEASURE_KEYS:
            near = key_hint(str(key), MEASURE_KEYS, table)
            yield _problem("unknown key", name, str(key), got=shown(key), hint=near)
    for key in ("signal", "statistic"):
        if key not in table:
            expected = f"one of {', '.join(STATISTICS)}" if key == "statistic" else MEASURE_KEYS[key]
            yield _problem(f"has no {key}", name, expected=expected, hint=hint)
    try:
        read_display_unit(table.get("unit", ""))
    except Refusal as error:
        yield _problem(str(error), name, "unit", got=shown(table["unit"]), hint=error.hint)
    signal, statistic = table.get("signal", "a.b"), table.get("statistic", LAST)
    if not isinstance(signal, str) or not all(NAME.fullmatch(part) for part in signal.split(".")) or "." not in signal:
        yield _problem("not an output", name, "signal", got=shown(signal), hint='write signal = "block.output"')
    if not isinstance(statistic, str) or statistic not in STATISTICS:
        same = next((own for own, others in ELSEWHERE.items() if str(statistic).lower() in others), "")
        near = f"here that is {same}" if same else did_you_mean(str(statistic), STATISTICS, "the statistics")
        yield _problem("there is no such statistic", name, "statistic", got=shown(statistic), hint=near)
        return
    wanted = STATISTICS[statistic].options
    for key in wanted:
        if key not in table:
            add = f"add {key} = {OPTIONS[key].example}"
            yield _problem(f"{statistic} needs {key}", name, expected=MEASURE_KEYS[key], hint=add)
    for key in set(table) & OPTIONS.keys() - wanted.keys():
        yield _problem(f"{statistic} has no {key}", name, key, got=shown(table[key]), hint="leave it out")
    times = dict[str, Fraction]()
    for key in sorted(MEASURE_TIMES):
        try:
            times[key] = read_duration(table.get(key, 0))
        except Refusal as error:
            yield _problem(str(error), name, key, got=shown(table[key]), hint=error.hint)
    if "until" in table and {"from", "until"} <= times.keys() and times["until"] <= times["from"]:
        yield _problem("ends before it begins", name, "until", got=_time(table["until"]), expected="after from")


def _time(entry: object) -> str:
    """Return a time as it is written, or of a graph that is read already."""
    return write_seconds(entry) if isinstance(entry, Fraction) else shown(entry)
