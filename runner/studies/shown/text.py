"""A study as text for people."""

from collections import Counter
from collections.abc import Iterator, Mapping

import numpy as np

from proofmass.graphs.studies.ages import age_text, some_of
from proofmass.runner.output.counts import count
from proofmass.runner.output.text_table import text_table
from proofmass.runner.output.times import time_text
from proofmass.runner.studies.outcome.intervals import concise
from proofmass.runner.studies.outcome.result import StudyResult, as_shown
from proofmass.runner.studies.shown.points import all_points_text, differences, parts

_COLUMNS = ("mean", "std", "p1", "p50", "p99")


def study_text(result: StudyResult) -> str:
    """Return size and time of a study, a table and the yields of each point of its sweep, and what failed."""
    result = as_shown(result)
    study, points = result.study, parts(result)
    runs, time = count(len(result.numbers), "run"), time_text(result.seconds)
    epochs = f" at {len(study.epochs)} epochs" if len(study.epochs) > 1 else ""
    lines = [f"{study.graph.name}: {runs}{epochs}, {result.engine} engine, {time}", ""]
    for name, part in points.items():
        yields = list(_yields(part))
        lines += [f"{name}:", ""] if name else []
        lines += [*_table(part), "", *yields]
        lines += [""] if yields and len(points) > 1 else []
    lines += _against_first(points)
    if len(points) < study.points:
        lines += ["", all_points_text(study)]
    planned = study.runs * study.points
    if result.planned_runs < planned:
        lines.append(f"stopped after {result.planned_runs:,} of {planned:,} runs: that was enough")
    lines += [f"the worker {address} ended early; others did its runs" for address in result.lost_workers]
    return "\n".join([*lines, *_first_fault(result)]).rstrip()


def _table(result: StudyResult) -> Iterator[str]:
    """A row for each measure and epoch; of many epochs some, the first and the last among them."""
    epochs = some_of(result.study.epochs)
    rows: list[tuple[str, ...]] = [("measure", "unit", "age", *_COLUMNS)]
    for row in (row for row in result.summary() if row["age_s"] in epochs):
        numbers = [concise(row[key], row["intervals"][key]) if key in row else "" for key in _COLUMNS]
        rows.append((row["measure"], "" if row["unit"] == "1" else row["unit"], age_text(row["age_s"]), *numbers))
    yield from text_table(rows, left=(0, 1))
    yield "in brackets half of the 95 % confidence interval, in units of the last digits; none of too few runs"
    yield from _without_value(result)


def _without_value(result: StudyResult) -> Iterator[str]:
    """Yield measures that runs without a fault have no value of, at the age at which most have none."""
    failed = Counter(epoch for _, epoch in result.faults)
    sound = [len(result.numbers) - failed[epoch] for epoch in range(len(result.study.epochs))]
    for measure in result.measures:
        known = np.isfinite(result.values[measure.name]).sum(axis=0).tolist()
        few, runs = min(zip(known, sound, strict=True), key=lambda pair: pair[0] - pair[1])
        if few < runs:
            yield f"{measure.name}: {few:,} of {count(runs, 'run')} have a value; the others do not count"


def _against_first(points: Mapping[str, StudyResult]) -> Iterator[str]:
    """Yield how far each point is from the first at the last age: the sensors are the same."""
    (first_name, first), *others = points.items()
    rows: list[tuple[str, ...]] = [("point", "measure", "unit", "difference")]
    for name, part in others:
        for row in (row for row in differences(first, part) if row["age_s"] == first.study.epochs[-1]):
            unit = "" if row["unit"] == "1" else row["unit"]
            rows.append((name, row["measure"], unit, concise(row["difference"], row["interval"])))
    if len(rows) > 1:
        yield f"against {first_name}, sensor by sensor, at {age_text(first.study.epochs[-1])}:"
        yield ""
        yield from text_table(rows, left=(0, 1, 2))


def _yields(result: StudyResult) -> Iterator[str]:
    intervals = result.yield_intervals()
    for name, good in result.yields().items():
        low, high = intervals[name]
        yield f"yield, {name}: {100 * good:.2f} %, with 95 % confidence {100 * low:.2f} to {100 * high:.2f} %"


def _first_fault(result: StudyResult) -> Iterator[str]:
    for (run, epoch), text in list(result.faults.items())[:1]:
        tried = len(result.numbers) * len(result.study.epochs)
        yield f"{len(result.faults):,} of {tried:,} failed; run {run} at epoch {epoch}: {text}"
