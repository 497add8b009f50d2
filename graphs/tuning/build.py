"""Reader of tunings: tables become a Tuning, or a list of all their faults."""

import math
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

from proofmass.blocks.declaration.parameter import plain
from proofmass.blocks.declaration.problem import ModelError, Refusal, did_you_mean, shown
from proofmass.graphs.checks.check import checked
from proofmass.graphs.model.adjustable import Adjustable
from proofmass.graphs.model.call_numbers import plain_tables
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import NOWHERE, Graph, Place
from proofmass.graphs.model.keys import FREE_KEYS, GOAL_KEYS, TUNE_INTEGERS, TUNE_KEYS, Integer
from proofmass.graphs.model.quantities import QUANTITY_KEYS, YieldOf, read_quantity_of
from proofmass.graphs.model.rates import read_duration
from proofmass.graphs.studies.study import Study
from proofmass.graphs.studies.study_tables import StudyTables, read_decibels
from proofmass.graphs.studies.table_entries import checked_table, read_flag, read_quantity
from proofmass.graphs.tuning.tuning import MOST_POINTS, Free, Goal, Tuning

TuningTables = Mapping[str, Any]
NOTHING: TuningTables = MappingProxyType({})
SCALES = ("linear", "logarithmic")
_WIDE = 8.0  # from this ratio of the bounds on the axis is logarithmic by default


def tuning_of(
    graph: Graph,
    *,
    free: TuningTables = NOTHING,
    goals: TuningTables = NOTHING,
    points: TuningTables = NOTHING,
    tolerances: TuningTables = NOTHING,
    ages: object = (),
    at: object = "",
    starts: object = TUNE_INTEGERS["starts"].default,
    samples: object = TUNE_INTEGERS["samples"].default,
    seed: object = TUNE_INTEGERS["seed"].default,
    study: Study | None = None,
    place: Place = NOWHERE,
) -> Tuning:
    """Return a tuning from tables as they stand in a graph file; raises `ModelError` with every problem.

    `study` is the study of the graph of which yields are goals, and whose drift counts at `ages`.
    """
    read = _Tables(checked(graph), docs=TUNE_KEYS)
    frees = read.parameters("free", free, _read_free)
    for name, problem in _outside(read, frees):
        read.refuse(problem, "free", read.written[name])
    wanted = read.read("goals", goals, lambda name, entry: read.goal(entry))
    for name, goal in wanted.items():
        if isinstance(goal.quantity, YieldOf) and study is None:
            hint = "add [study] with spread and limits to the file"
            read.refuse(Refusal("a yield is wanted, and there is no study with limits", hint), "goals", name)
    own_points = {
        name: read.parameters(f"points.{name}", table, lambda entry, unit: read_quantity({"": entry}, "", unit))
        for name, table in read.entries("points", points)
    }
    for name in frees:
        if own_points and all(name in point for point in own_points.values()):
            hint = "leave it out here, or in the points"
            read.refuse(Refusal("leaves nothing free: every operating point sets it", hint), "free", read.written[name])
    corners = read.parameters("tolerances", tolerances, lambda value, unit: _tolerance(value))
    for key, entries, what, example in (("free", frees, "parameter", _FREE), ("goals", wanted, "goal", _GOAL)):
        if not entries and not read.problems:
            read.refuse(Refusal(f"names no {what}", example), key)
    moment = read.moment("at", at)
    given = {"starts": plain(starts), "samples": plain(samples), "seed": plain(seed)}
    numbers = {key: read.count(key, given[key], form) for key, form in TUNE_INTEGERS.items()}
    own_ages = read.ages_of(ages, study, wanted)
    cases = max(1, len(own_points)) * max(1, len(own_ages)) * 2 ** len(corners)
    if cases > MOST_POINTS:
        hint = "leave out tolerances that matter little; proofmass worst ranks them"
        got, expected = f"{cases} operating points and corners", f"at most {MOST_POINTS}"
        read.refuse(Refusal("too many", hint, got=got, expected=expected), "tolerances")
    tuning = Tuning(
        graph=graph,
        flat=flatten(graph),
        free=frees,
        goals=wanted,
        points=own_points,
        tolerances=corners,
        ages=own_ages,
        at=moment,
        written=MappingProxyType(read.written),
        study=study,
        place=place,
        **numbers,
    )
    if read.problems:
        raise ModelError([tuning.placed(problem) for problem in read.problems])
    return tuning


_FREE = 'add [tune.free] and below it "pid.integral" = { at_least = "1 1/s", at_most = "100 1/s" }'
_GOAL = 'add [tune.goals] and below it phase = { loop = "main", figure = "phase_margin", at_least = "60 deg" }'


class _Tables(StudyTables):
    def goal(self, entry: object) -> Goal:
        """Read a goal; raises `Refusal`."""
        table = checked_table(entry, {**QUANTITY_KEYS, **GOAL_KEYS}, _GOAL)
        quantity = read_quantity_of(table, self.flat)
        limits = {key: _limit(table, key, quantity.unit) for key in ("at_least", "at_most") if key in table}
        flags = {key: read_flag(table, key) for key in ("soft", "minimise", "maximise")}
        if flags["minimise"] + flags["maximise"] + bool(limits) != 1:
            expected = "limits (at_least, at_most), or one of minimise = true and maximise = true"
            raise Refusal("must say what is wanted", got=shown(dict(table)), expected=expected)
        if flags["soft"] and not limits:
            raise Refusal("is soft as it is", "leave soft out, or give a limit", key="soft", got="true")
        if limits.get("at_least", -math.inf) > limits.get("at_most", math.inf):
            raise Refusal("nothing can meet it", got=shown(dict(table)), expected="at_least below at_most")
        if getattr(quantity, "figure", "") == "settling_time" and flags["maximise"]:
            raise Refusal("a settling time has no upper end", key="maximise", got="true")
        low, high = limits.get("at_least", -math.inf), limits.get("at_most", math.inf)
        return Goal(quantity, low, high, **flags)

    def ages_of(self, ages: object, study: Study | None, goals: Mapping[str, Goal]) -> tuple[float, ...]:
        """Read the ages at which goals hold."""
        ages = plain_tables(ages)
        if not ages:
            return ()
        example = 'write ages = ["0 h", "15 year"]'
        if study is None or not study.drift:
            self.refuse(Refusal("nothing drifts", "add [study.drift] to the file", got=shown(ages)), "ages")
        elif any(isinstance(goal.quantity, YieldOf) for goal in goals.values()):
            self.refuse(Refusal("a yield has the ages of its study", "leave ages out", got=shown(ages)), "ages")
        if not isinstance(ages, list | tuple):
            self.refuse(Refusal("must be a list of ages", example, got=shown(ages)), "ages")
            return ()
        try:
            return tuple(float(read_duration(age)) for age in ages)
        except Refusal as error:
            self.refuse(Refusal(str(error), example, got=shown(ages)), "ages")
        return ()

    def count(self, key: str, value: object, form: Integer) -> int:
        """Read an integer."""
        if not form.whole(value) or not form.holds(value):
            expected = f"an integer from {form.lowest} to {form.highest:g}"
            self.refuse(Refusal("out of range", got=shown(value), expected=expected), key)
            return form.lowest
        return value


def _read_free(entry: object, unit: str) -> Free:
    table = checked_table(entry, FREE_KEYS, 'write { at_least = "1 1/s", at_most = "100 1/s" }')
    for key in ("at_least", "at_most"):
        if key not in table:
            raise Refusal(f"has no {key}", FREE_KEYS[key], got=shown(dict(table)))
    low, high = (read_quantity(table, key, unit) for key in ("at_least", "at_most"))
    if low >= high:
        raise Refusal("leaves nothing free", got=shown(dict(table)), expected="at_least below at_most")
    scale = table.get("scale", SCALES[low > 0.0 and high / low >= _WIDE])
    if scale not in SCALES:
        hint = did_you_mean(str(scale), SCALES, "the scales")
        raise Refusal("there is no such scale", hint, key="scale", got=shown(scale))
    if scale == "logarithmic" and low <= 0.0:
        raise Refusal("a logarithmic axis needs positive bounds", key="scale", got=shown(dict(table)))
    return Free(low, high, scale == "logarithmic")


def _outside(read: _Tables, frees: Mapping[str, Free]) -> Iterator[tuple[str, Refusal]]:
    """Yield parameters whose bounds the block refuses."""
    adjustable = Adjustable(read.flat)
    for name, free in frees.items():
        for key, value in (("at_least", free.at_least), ("at_most", free.at_most)):
            if not adjustable.takes(name, value):
                yield name, Refusal("the block does not take it", key=key, got=f"{value:g}")


def _limit(table: TuningTables, key: str, unit: str) -> float:
    """Read a limit in the unit of its quantity; nothing else is measured in decibels."""
    if unit == "dB":
        return read_decibels(table, key)
    if unit == "%":
        return (100.0 if isinstance(table[key], str) else 1.0) * read_quantity(table, key, "1")
    return read_quantity(table, key, unit)


def _tolerance(entry: object) -> float:
    value = read_quantity({"": entry}, "", "1", at_least=0.0)
    if value >= 1.0:
        raise Refusal("is not a tolerance", 'write a part of the value, as "5 %"', got=shown(entry))
    return value
