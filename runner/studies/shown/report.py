"""A study as one HTML file: yield, tables, distributions, influences, and the runs to look at again."""

import math
import shlex
from collections.abc import Callable, Iterator, Sequence
from html import escape
from pathlib import Path

import numpy as np

from proofmass.blocks.declaration.catalog import own_file
from proofmass.blocks.declaration.shown_units import pretty
from proofmass.graphs.studies.ages import age_text, some_of
from proofmass.graphs.studies.study import Study
from proofmass.graphs.studies.study_writer import write_study
from proofmass.runner.output.counts import count
from proofmass.runner.output.page import broken, facts, paragraphs, picture, save_page, small, table
from proofmass.runner.studies.kept.folder import STUDY_FILE
from proofmass.runner.studies.outcome.intervals import LEVEL, concise
from proofmass.runner.studies.outcome.result import PERCENTILES, StudyResult
from proofmass.runner.studies.shown.influences import Influences, drawn_of, influences_at
from proofmass.runner.studies.shown.plot import label_of, plot_measure
from proofmass.runner.studies.shown.plot_influences import plot_influences
from proofmass.runner.studies.shown.points import MOST_POINTS, all_points_text, first_point, parts, swept_parts
from proofmass.runner.studies.shown.sensitivities import Influence, sobol_indices
from proofmass.runner.studies.shown.worst import WorstRun, failed_runs, worst_runs

FILE = "report.html"
_WORST = 5
_FAILED = 10
_LEADING = 3  # factors of a measure at one age
Section = Callable[[StudyResult], str]


def save_study_report(result: StudyResult, path: str | Path) -> Path:
    """Write the report; its commands replay runs of the study in the same folder."""
    sections = [
        *([("Yield", _yield(result))] if result.yields() else []),
        ("Measures", _measures(result)),
        ("Distributions", _distributions(result)),
        *([("What scatters them", influences)] if (influences := _influences(result)) else []),
        *([("Sobol indices", indices)] if (indices := _indices(result)) else []),
        ("Runs to look at", _worst(result)),
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


def _at_each(points: Callable[[StudyResult], dict[str, StudyResult]]) -> Callable[[Section], Section]:
    """Return a section for each point of the study, under headings if there are several."""

    def decorated(section: Section) -> Section:
        def whole(result: StudyResult) -> str:
            told_apart = points(result)
            if len(told_apart) == 1:
                together = f"<p>{all_points_text(result.study).capitalize()}.</p>\n"
                body = section(result)
                return together + body if body and result.study.points > MOST_POINTS else body
            bodies = {name if "=" in name else name.capitalize(): section(part) for name, part in told_apart.items()}
            return "\n".join(f"<h3>{escape(head)}</h3>\n{body}" for head, body in bodies.items() if body)

        return whole

    return decorated


@_at_each(parts)
def _yield(result: StudyResult) -> str:
    intervals, rows = result.yield_intervals(), []
    for name, part in result.yields().items():
        limit = result.study.limits.get(name)
        edges = [] if limit is None else [("≥", limit.at_least), ("≤", limit.at_most), ("change ≤", limit.change)]
        said = ", ".join(f"{sign} {edge:g}" for sign, edge in edges if math.isfinite(edge))
        said += f", from {age_text(limit.start)}" if limit is not None and limit.start else ""
        low, high = intervals[name]
        rows.append(
            f'<th>{broken(name)}</th><td>{escape(said)}</td><td class="number">{100 * part:.2f} %</td>'
            f'<td class="number">{100 * low:.2f} to {100 * high:.2f} %</td>'
        )
    return table(("measure", "limit", "good", f"{100 * LEVEL:g} % confidence"), rows, numbers=(2, 3))


@_at_each(parts)
def _tables(result: StudyResult) -> str:
    keys = ("mean", "std", *(f"p{p:g}" for p in PERCENTILES))
    rows = []
    shown = some_of(result.study.epochs)
    for row in (row for row in result.summary() if row["age_s"] in shown):
        cells = "".join(f'<td class="number">{_with_interval(row, key)}</td>' for key in keys)
        age = escape(age_text(row["age_s"]))
        rows.append(
            f"<th>{broken(row['measure'])}</th><td>{escape(pretty(row['unit']))}</td>"
            f'<td class="number">{age}</td><td class="number">{row["runs"]:,}</td>{cells}'
        )
    return table(("measure", "unit", "age", "runs", *keys), rows, numbers=range(2, 4 + len(keys)))


def _measures(result: StudyResult) -> str:
    about = (
        f"<p>In brackets half of the {100 * LEVEL:g} % confidence interval, in units of the last digits; below it the"
        " interval. Runs that failed are left out.</p>"
    )
    return about + _tables(result)


def _with_interval(row: dict[str, object], key: str) -> str:
    value, intervals = row.get(key), row.get("intervals")
    if not isinstance(value, float) or not isinstance(intervals, dict):
        return ""
    low, high = intervals[key]
    return f"{concise(value, (low, high))}<br>{small(_ends(low, high))}"


def _ends(low: float, high: float) -> str:
    """Return an interval with as many digits as distinguish its ends.

    >>> _ends(3275.8213, 3277.61), _ends(1.0000464, 1.0000566), _ends(-math.inf, 2.0), _ends(1.0, math.inf)
    ('3275.82 to 3277.61', '1.000046 to 1.000057', '≤ 2', '≥ 1')
    """
    if math.isinf(low) or math.isinf(high):
        return f"≤ {high:.5g}" if math.isfinite(high) else f"≥ {low:.5g}" if math.isfinite(low) else "unknown"
    ratio = max(abs(low), abs(high)) / (high - low) if high > low else 1.0
    digits = min(15, max(5, math.ceil(math.log10(ratio)) + 2))
    return f"{low:.{digits}g} to {high:.{digits}g}"


@_at_each(swept_parts)
def _distributions(result: StudyResult) -> str:
    point = first_point(result)
    return "\n".join(
        f'<div class="wide">{picture(plot_measure(result, m.name), f"{m.name}-distribution-{point}")}</div>'
        for m in result.measures
    )


@_at_each(parts)
def _influences(result: StudyResult) -> str:
    """Return a tornado of each measure at the last epoch, and the strongest factors at the others."""
    if not len(result.numbers):
        return ""
    drawn, study, last = drawn_of(result), result.study, len(result.study.epochs) - 1
    earlier = [epoch for epoch, age in enumerate(study.epochs) if age in some_of(study.epochs)]
    ages: dict[str, list[Influences]] = {}
    for epoch in earlier:
        for influences in influences_at(result, drawn, epoch):
            ages.setdefault(influences.measure.name, []).append(influences)
    shown = []
    for measure, found in ages.items():
        shown += [_tornado(result, found[-1])] if found[-1].epoch == last else []
        shown += [_leading(study, found)] if len(found) > 1 else []
        shown += [] if found[-1].epoch == last else [f"<p>{escape(measure)} does not scatter at the last age.</p>"]
    return "\n".join(shown)


def _tornado(result: StudyResult, influences: Influences) -> str:
    regression, measure, study = influences.regression, influences.measure, result.study
    about = (
        f"Linear regression explains {_percent(regression.explained)} of the variance of {measure.name} at the age of "
        f"{age_text(study.epochs[influences.epoch])} ({_percent(regression.explained_of_ranks)} for ranks)."
    )
    about += _since_text(study, influences)
    rows = (
        f'<th>{broken(i.parameter)}</th><td class="number">{i.slope:.5g}</td><td class="number">{_effect(i)}</td>'
        f'<td class="number">{i.standardised:.4f}</td><td class="number">{i.rank:.4f}</td>'
        for i in regression.influences
    )
    heads = ("factor", "slope", "effect of 1 σ", "standardised", "of ranks")
    drawing = picture(
        plot_influences(influences.factors, regression, influences.values, label_of(measure)),
        f"{measure.name}-influences-{first_point(result)}",
    )
    return f'<p>{escape(about)}</p><div class="wide">{drawing}</div>{table(heads, rows, range(1, 5))}'


def _since_text(study: Study, influences: Influences) -> str:
    """Return since when changes are counted, if parameters drift."""
    if not study.drift or influences.epoch == 0:
        return ""
    first = influences.since[0]
    same = (influences.since == first).all()
    what = "calibration" if study.recalibration.carried else "age"
    at = f", at {age_text(study.epochs[int(first)])}" if same and study.recalibration.carried else ""
    return f" Changes are those since the {'last' if study.recalibration.carried else 'first'} {what}{at}."


def _leading(study: Study, tables: Sequence[Influences]) -> str:
    """Return the strongest factors of one measure at each age."""
    rows = []
    for influences in tables:
        named = ", ".join(f"{i.parameter} {i.effect:.4g}" for i in influences.regression.influences[:_LEADING])
        rows.append(
            f'<td class="number">{escape(age_text(study.epochs[influences.epoch]))}</td>'
            f'<td class="number">{_percent(influences.regression.explained)}</td><td>{broken(named)}</td>'
        )
    return table(("age", "explained", "strongest factors, effect of 1 σ"), rows, numbers=(0, 1))


def _percent(part: float) -> str:
    """Return a part of a variance in percent, with enough digits to distinguish it from 100 %.

    >>> _percent(0.204), _percent(0.99987), _percent(1.0)
    ('20.4 %', '99.99 %', '100 %')
    """
    text = f"{100.0 * part:.1f} %"
    return text if text != "100.0 %" else "100 %" if part > 0.99995 else f"{100.0 * part:.2f} %"


def _effect(influence: Influence) -> str:
    low, high = influence.effect - influence.effect_half, influence.effect + influence.effect_half
    return f"{concise(influence.effect, (low, high))}<br>{small(_ends(low, high))}"


def _indices(result: StudyResult) -> str:
    tables = _index_tables(result)
    if not tables:
        return ""
    drifting = ", ".join(map(result.study.name_of, result.study.drift))
    left_out = f"the noise, and the drift of {drifting}" if drifting else "the noise"
    return f"<p>Sensors of a group share {escape(left_out)}; what these do is in no index.</p>\n{tables}"


@_at_each(parts)
def _index_tables(result: StudyResult) -> str:
    last, rows = len(result.study.epochs) - 1, []
    for measure in result.measures:
        for index in sobol_indices(result, measure.name, last, first_point(result)) if len(result.numbers) else ():
            cells = (
                f"{value:.3f}<br>{small(f'{low:.3f} to {high:.3f}')}"
                for value, (low, high) in ((index.first, index.first_interval), (index.total, index.total_interval))
            )
            numbers = "".join(f'<td class="number">{cell}</td>' for cell in cells)
            parameter = broken(result.study.name_of(index.parameter))
            rows.append(f"<th>{broken(measure.name)}</th><td>{parameter}</td>{numbers}")
    return table(("measure", "parameter", "first order", "total"), rows, numbers=(2, 3)) if rows else ""


def _worst(result: StudyResult) -> str:
    rows = list(_rows(result, "failed", failed_runs(result, _FAILED)))
    for measure in result.measures:
        rows += _rows(result, measure.name, worst_runs(result, measure.name, _WORST))
    heads = ("measure", "run", "age", "value", "", "to replay it")
    return table(heads, rows, numbers=(1, 2, 3)) if rows else "<p>No runs.</p>"


def _rows(result: StudyResult, name: str, runs: Sequence[WorstRun]) -> Iterator[str]:
    for worst in runs:
        command = _command(result, "--run", str(worst.run), *(("--epoch", str(worst.epoch)) if worst.epoch else ()))
        value = "" if np.isnan(worst.value) else f"{worst.value:.9g}"
        age = escape(age_text(result.study.epochs[worst.epoch]))
        yield (
            f'<th>{broken(name)}</th><td class="number">{worst.run}</td>'
            f'<td class="number">{age}</td><td class="number">{value}</td>'
            f"<td>{small(worst.why)}</td><td><code>{escape(command)}</code></td>"
        )


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
        "SHA-256 of the values": result.digest,
        "SHA-256 of the graph": provenance.pop("graph_hash", ""),
        "time": f"{result.seconds:.4g} s" if result.seconds else "",
        **provenance,
    }
    return facts(about.items())


def _repeat(result: StudyResult) -> str:
    text = write_study(result.study)
    return (
        f"<p>In the folder of this report; <code>{STUDY_FILE}</code> is the study below.</p>"
        f"<pre>{escape(_command(result, '--out', '.'))}</pre>\n<pre>{escape(text)}</pre>"
    )
