"""A study as one HTML file: yield, tables, distributions, influences, and runs to look at."""

import math
import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

import numpy as np

from proofmass.blocks.declaration.catalog import own_file
from proofmass.blocks.declaration.shown_units import in_print, in_table, relative_text
from proofmass.graphs.studies.ages import age_text, some_of
from proofmass.graphs.studies.study import Study
from proofmass.graphs.studies.study_tables import Limit
from proofmass.graphs.studies.study_writer import write_study
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.output.counts import count
from proofmass.runner.output.page import Html, broken, facts, folded, paragraphs, picture, save_page, small, table
from proofmass.runner.studies.kept.folder import STUDY_FILE
from proofmass.runner.studies.outcome.intervals import LEVEL, concise
from proofmass.runner.studies.outcome.result import PERCENTILES, StudyResult, as_shown
from proofmass.runner.studies.shown.curves import sweep_picture
from proofmass.runner.studies.shown.influences import Influences, StudyInfluences, one_age
from proofmass.runner.studies.shown.plot import plot_distribution, plot_influences, plot_shares
from proofmass.runner.studies.shown.points import first_point, parts, swept_parts
from proofmass.runner.studies.shown.proved import ProvedBound, bounds_of, proved_section
from proofmass.runner.studies.shown.report_lifetimes import calibrations_section, lifetimes_section
from proofmass.runner.studies.shown.report_sections import at_each, ends_text, percent_text
from proofmass.runner.studies.shown.sensitivities import Influence, sobol_indices

FILE = "report.html"
_CHANGE = "change ≤"
_WORST = 5
_FAILED = 10
_LEADING = 3  # factors of a measure at one age
BEYOND = "beyond its limit"


@dataclass(frozen=True)
class WorstRun:
    """A run at an epoch, and why it is named."""

    run: int
    epoch: int
    value: float  # of the measure; NaN where the run failed
    why: str


def save_study_report(
    result: StudyResult,
    path: str | Path,
    influences: StudyInfluences | None = None,
    proved: Sequence[ProvedBound] = (),
) -> Path:
    """Write the report; its commands replay runs of the study in the same folder.

    `influences` are computed if they are not known already. What is `proved` stands beside.
    """
    shown = as_shown(result)
    known = influences if influences and shown is result else StudyInfluences(shown)
    sections = [
        *([("Yield", _yield(shown))] if result.yields() else []),
        *([("Lifetimes", lives)] if (lives := lifetimes_section(shown)) else []),
        *([("What calibrations buy", bought)] if (bought := calibrations_section(shown)) else []),
        ("Measures", _measures(shown)),
        *([("Proved", proved_section(shown, proved))] if proved else []),
        ("Distributions", _distributions(shown, proved)),
        *([("Curves over the sweep", curves)] if (curves := _curves(shown)) else []),
        *([("What scatters them", tables)] if (tables := _influences(shown, known)) else []),
        *([("Sobol indices", indices)] if (indices := _indices(shown)) else []),
        ("Runs to look at", _worst(shown)),
        ("Study", _facts(result)),
        ("To repeat it", _repeat(result)),
    ]
    footer = f"proofmass {result.provenance.get('proofmass', '')}, {result.provenance.get('date', '')}"
    return save_page(path, result.study.graph.name, _opening(result), sections, footer)


def _opening(result: StudyResult) -> str:
    study = result.study
    texts = paragraphs(study.graph.description)
    ages = f" at {len(study.epochs)} ages up to {age_text(study.epochs[-1])}" if len(study.epochs) > 1 else ""
    swept, intervals = study.points // len(study.recalibration.every), len(study.recalibration.every)
    points = f", {swept} points of the sweep" if swept > 1 else ""
    points += f", {intervals} intervals between calibrations" if intervals > 1 else ""
    texts.append(f'<span class="soft">{count(len(result.numbers), "run")}{ages}{points}, seed {study.seed}</span>')
    page = "".join(f"<p>{text}</p>\n" for text in texts)
    if result.interrupted:
        page += f'<p class="warning">{len(result.numbers):,} of {result.planned_runs:,} runs are done.</p>'
    return page


@at_each(parts)
def _yield(result: StudyResult) -> str:
    intervals, rows = result.yield_intervals(), []
    for name, part in result.yields().items():
        limit = result.study.limits.get(name)
        edges = [] if limit is None else [("≥", limit.at_least), ("≤", limit.at_most), (_CHANGE, limit.change)]
        unit = next((measure.unit for measure in result.measures if measure.name == name), "1")
        said = ", ".join(
            f"{sign} {relative_text(edge) if sign == _CHANGE else in_print(edge, unit, 6)}"
            for sign, edge in edges
            if math.isfinite(edge)
        )
        said += f", from {age_text(limit.start)}" if limit is not None and limit.start else ""
        low, high = intervals[name]
        rows.append((broken(name), said, f"{100 * part:.2f} %", f"{100 * low:.2f} to {100 * high:.2f} %"))
    return table(("measure", "limit", "good", f"{100 * LEVEL:g} % confidence"), rows, numbers=(2, 3))


@at_each(parts)
def _tables(result: StudyResult) -> str:
    keys = ("mean", "std", *(f"p{p:g}" for p in PERCENTILES))
    rows = []
    shown = some_of(result.study.epochs)
    for row in (row for row in result.summary() if row["age_s"] in shown):
        unit, cells = in_table(row["unit"]), (_with_interval(row, key) for key in keys)
        rows.append((broken(row["measure"]), unit, age_text(row["age_s"]), f"{row['runs']:,}", *cells))
    heads = ("measure", "unit", "age", "runs", *keys)
    return table(heads, rows, numbers=range(2, len(heads)))


def _measures(result: StudyResult) -> str:
    about = (
        f"<p>In brackets half of the {100 * LEVEL:g} % confidence interval, in units of the last digits; below"
        " percentiles that few runs tell of, their bound. Runs that failed are left out.</p>"
    )
    return about + _tables(result)


def _with_interval(row: dict[str, object], key: str) -> Html:
    value, intervals = row.get(key), row.get("intervals")
    if not isinstance(value, float) or not isinstance(intervals, dict):
        return Html()
    low, high = intervals[key]
    bound = "" if all(map(math.isfinite, (low, high))) else f"<br>{small(ends_text(low, high))}"
    return Html(f"{concise(value, (low, high))}{bound}")


def _distributions(result: StudyResult, proved: Sequence[ProvedBound]) -> str:
    @at_each(swept_parts)
    def shown(part: StudyResult) -> str:
        drawn = ((m.name, plot_distribution(part, m, bounds_of(proved, m.name))) for m in part.measures)
        return "\n".join(f'<div class="wide">{picture(one, f"distribution of {name}")}</div>' for name, one in drawn)

    return shown(result)


def _curves(result: StudyResult) -> str:
    """Return each measure against each parameter that takes three values or more."""
    names = [name for name, values in result.study.sweep.items() if len(set(values)) > 2]
    return "\n".join(
        f'<div class="wide">{sweep_picture(result, measure, name)}</div>'
        for name in names
        for measure in result.measures
        if np.isfinite(result[measure.name]).any()
    )


def _influences(result: StudyResult, known: StudyInfluences) -> str:
    """Return a tornado of each measure at the last epoch, and the shares of the strongest factors at every one."""

    @at_each(parts)
    def shown(part: StudyResult) -> str:
        ages = known.by_measure(part)
        return "\n".join(_of_measure(part, name, tables) for name, tables in ages.items())

    return shown(result)


def _of_measure(result: StudyResult, name: str, tables: Sequence[Influences]) -> str:
    study, last = result.study, len(result.study.epochs) - 1
    newest = tables[-1].epoch == last
    pieces = [_tornado(result, tables[-1])] if newest else []
    if len(tables) > 1:
        shares = plot_shares([study.epochs[t.epoch] for t in tables], [t.regression for t in tables])
        drawing = picture(shares, f"what scatters {name} at each age")
        shown = [t for t in tables if study.epochs[t.epoch] in some_of(study.epochs)]
        pieces += [f'<div class="wide">{drawing}</div>', _leading(study, shown)]
    pieces += [] if newest else [f"<p>{escape(name)} does not scatter at the last age.</p>"]
    return "\n".join(pieces)


def _tornado(result: StudyResult, influences: Influences) -> str:
    regression, measure, study = influences.regression, influences.measure, result.study
    about = (
        f"Linear regression explains {percent_text(regression.explained)} of the variance of {measure.name} at the age "
        f"of {age_text(study.epochs[influences.epoch])} ({percent_text(regression.explained_of_ranks)} for ranks)."
    )
    about += _since_text(study, influences)
    rows = []
    for i in regression.influences:
        numbers = _effect(i), percent_text(i.share), f"{i.standardised:.4f}", f"{i.rank:.4f}"
        rows.append((broken(i.parameter), f"{i.slope:.5g}", *numbers))
    heads = ("factor", "slope", "effect of 1 σ", "share of variance", "standardised", "of ranks")
    drawing = picture(plot_influences(influences), f"influences on {measure.name}")
    return f'<p>{escape(about)}</p><div class="wide">{drawing}</div>{table(heads, rows, range(1, 6))}'


def _since_text(study: Study, influences: Influences) -> str:
    """Return since when changes are counted, if parameters drift."""
    if not study.drift or influences.epoch == 0:
        return ""
    if not study.recalibration.carried:
        return " Changes are those since the first age."
    age = one_age(study.epochs, influences.since)
    return f" Changes are those since the last calibration{'' if math.isnan(age) else f', at {age_text(age)}'}."


def _leading(study: Study, tables: Sequence[Influences]) -> str:
    """Return the strongest factors of one measure at each age."""
    rows = []
    for influences in tables:
        named = ", ".join(f"{i.parameter} {percent_text(i.share)}" for i in influences.regression.influences[:_LEADING])
        explained = percent_text(influences.regression.explained)
        rows.append((age_text(study.epochs[influences.epoch]), explained, broken(named)))
    return table(("age", "explained", "strongest factors, share of the variance"), rows, numbers=(0, 1))


def _effect(influence: Influence) -> Html:
    low, high = influence.effect - influence.effect_half, influence.effect + influence.effect_half
    return Html(f"{concise(influence.effect, (low, high))}<br>{small(ends_text(low, high))}")


def _indices(result: StudyResult) -> str:
    tables = _index_tables(result)
    if not tables:
        return ""
    drifting = ", ".join(map(result.study.name_of, result.study.drift))
    left_out = f"the noise, and the drift of {drifting}" if drifting else "the noise"
    return f"<p>Sensors of a group share {escape(left_out)}; what these do is in no index.</p>\n{tables}"


@at_each(parts)
def _index_tables(result: StudyResult) -> str:
    last, rows = len(result.study.epochs) - 1, []
    for measure in result.measures:
        for index in sobol_indices(result, measure.name, last, first_point(result)) if len(result.numbers) else ():
            cells = (
                Html(f"{value:.3f}<br>{small(f'{low:.3f} to {high:.3f}')}")
                for value, (low, high) in ((index.first, index.first_interval), (index.total, index.total_interval))
            )
            rows.append((broken(measure.name), broken(result.study.name_of(index.parameter)), *cells))
    return table(("measure", "parameter", "first order", "total"), rows, numbers=(2, 3)) if rows else ""


def _worst(result: StudyResult) -> str:
    rows = list(_rows(result, "failed", failed_runs(result, _FAILED)))
    worst = {measure.name: worst_runs(result, measure.name, _WORST) for measure in result.measures}
    failing = [name for name, runs in worst.items() if any(BEYOND in run.why for run in runs)]
    for name in (*failing, *(name for name in worst if name not in failing)):  # what misses a limit comes first
        rows += _rows(result, name, worst[name])
    heads = ("measure", "run", "age", "value", "", "to replay it")
    return table(heads, rows, numbers=(1, 2, 3)) if rows else "<p>No runs.</p>"


def _rows(result: StudyResult, name: str, runs: Sequence[WorstRun]) -> Iterator[tuple[str, ...]]:
    for worst in runs:
        command = _command(result, "--run", str(worst.run), *(("--epoch", str(worst.epoch)) if worst.epoch else ()))
        value = "" if np.isnan(worst.value) else f"{worst.value:.6g}"
        age, code = age_text(result.study.epochs[worst.epoch]), Html(f"<code>{escape(command)}</code>")
        yield broken(name), str(worst.run), age, value, small(worst.why), code


def _command(result: StudyResult, *words: str) -> str:
    files = {own_file(type(block)) for block in result.study.flat.blocks.values()} - {None}
    own = [word for file in sorted(map(str, files)) for word in ("--blocks", file)]
    return shlex.join(["proofmass", "montecarlo", STUDY_FILE, *own, *words])


def _facts(result: StudyResult) -> str:
    provenance = dict(result.provenance)
    about = {
        "design": result.study.design,
        "runs": f"{len(result.numbers):,} of {result.planned_runs:,}",
        "failed": f"{len(result.faults):,}",
        "time": in_print(result.seconds, "s") if result.seconds else "",
    }
    origin = {
        "SHA-256 of the values": result.digest,
        "SHA-256 of the graph": provenance.pop("graph_hash", ""),
        **provenance,
    }
    return facts(about.items()) + folded("hashes and versions", facts(origin.items()))


def _repeat(result: StudyResult) -> str:
    text = write_study(result.study)
    return (
        f"<p>In the folder of this report; <code>{STUDY_FILE}</code> is the study below.</p>"
        f"<pre>{escape(_command(result, '--out', '.'))}</pre>\n" + folded(STUDY_FILE, f"<pre>{escape(text)}</pre>")
    )


def failed_runs(result: StudyResult, most: int) -> list[WorstRun]:
    """Return the first runs that failed."""
    return [WorstRun(run, epoch, math.nan, text) for (run, epoch), text in list(result.faults.items())[:most]]


def worst_runs(result: StudyResult, measure: str, most: int) -> list[WorstRun]:
    """Return runs, each once, by distance beyond the limits of a measure, or from its median if it has no limit."""
    values = result[measure]
    if not np.isfinite(values).any():
        return []
    limit = result.study.limits.get(measure)
    distances = _from_median(values) if limit is None else _beyond(values, limit, result.study.epochs)
    distances = np.where(np.isfinite(values), distances, -np.inf)
    epochs = distances.argmax(axis=1)
    farthest = distances[np.arange(len(epochs)), epochs]
    order = [row for row in np.argsort(-farthest, kind="stable")[:most] if np.isfinite(farthest[row])]
    return [_named(result, measure, int(row), int(epochs[row]), float(farthest[row]), limit) for row in order]


def _named(result: StudyResult, measure: str, row: int, epoch: int, distance: float, limit: Limit | None) -> WorstRun:
    where = "from the median" if limit is None else BEYOND if distance > 0.0 else "within its limit"
    return WorstRun(int(result.numbers[row]), epoch, float(result[measure][row, epoch]), f"{abs(distance):.4g} {where}")


def _from_median(values: AnyArray) -> AnyArray:
    return np.asarray(np.abs(values - np.nanmedian(values, axis=0)))


def _beyond(values: AnyArray, limit: Limit, ages: Sequence[float]) -> AnyArray:
    """Return the distance of each value beyond the nearest limit; negative inside, NaN at epochs that do not count."""
    counted = limit.counted(ages)
    beyond = np.maximum(limit.at_least - values, values - limit.at_most)
    if math.isfinite(limit.change):
        first = values[:, counted : counted + 1]
        beyond = np.maximum(beyond, np.abs(values - first) - limit.change * np.abs(first))
    return np.where(np.arange(len(ages)) < counted, np.nan, beyond)
