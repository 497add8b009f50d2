"""Comparisons as tables, for the terminal and for a page."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from html import escape
from itertools import takewhile
from pathlib import Path

from proofmass.graphs.model.differences import GraphDifference
from proofmass.graphs.studies.ages import age_text
from proofmass.runner.comparison.runs import MeasureChange, RunComparison, TraceChange
from proofmass.runner.comparison.studies import MeanChange, StudyComparison, YieldChange
from proofmass.runner.output.page import save_page
from proofmass.runner.output.page import table as page_table
from proofmass.runner.output.text_table import text_table

_LONGEST, _BEFORE = 60, 20  # characters of what stands in a graph, and before what differs
_MARKS = {"added": "+", "removed": "-", "changed": "~", "renamed": ">"}


@dataclass(frozen=True)
class Table:
    """Rows of cells under a title; columns in `left` are texts."""

    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    left: tuple[int, ...]


def difference_table(title: str, differences: Iterable[GraphDifference]) -> Table:
    """Return what differs between two graphs, or the questions of two studies."""
    rows = tuple(
        (_MARKS[d.what], d.key, *_cut(d.before, d.after), f"follows {d.follows}" if d.follows else "")
        for d in differences
    )
    return Table(title, ("", "key", "before", "after", ""), rows, (0, 1, 2, 3, 4))


def run_tables(comparison: RunComparison) -> list[Table]:
    """Return the tables of two runs."""
    return [
        difference_table("graph", comparison.graph),
        difference_table("run", comparison.facts),
        Table(
            "traces",
            ("signal", "unit", "rows", "largest difference", "rms", "differs from"),
            tuple(map(_trace, comparison.traces)),
            (0, 1, 5),
        ),
        _figures("measure", comparison.measures),
        _figures("margin", comparison.margins),
        Table("notes", ("",), tuple((note,) for note in comparison.notes), (0,)),
    ]


def _figures(name: str, changes: Iterable[MeasureChange]) -> Table:
    heads = (name, "unit", "before", "after", "change", "")
    return Table(f"{name}s", heads, tuple(map(_measure, changes)), (0, 1, 5))


def study_tables(comparison: StudyComparison) -> list[Table]:
    """Return the tables of two studies."""
    how = "sensor by sensor" if comparison.paired else "as independent samples"
    return [
        difference_table("graph and study", comparison.differences),
        Table(
            f"means, compared {how}",
            ("point", "measure", "unit", "age", "before", "after", "change", "95 % interval", "pairs gain", ""),
            tuple(map(_mean, comparison.means)),
            (0, 1, 2, 9),
        ),
        Table(
            "yields",
            ("point", "limit", "age", "before", "after", "probability", ""),
            tuple(map(_yield, comparison.yields)),
            (0, 1, 6),
        ),
        Table("of one sensor alone, which differ", ("measure",), tuple((one,) for one in comparison.alone), (0,)),
    ]


def text_of(tables: Sequence[Table]) -> Iterator[str]:
    """Yield the lines of the tables that have rows, their titles where there is more than one."""
    full = [table for table in tables if table.rows]
    for number, table in enumerate(full):
        title = [table.title] if len(full) > 1 else []
        yield from ([""] if number else []) + title
        yield from text_table([table.heads, *table.rows], left=table.left)


def save_tables(
    path: Path, title: str, verdict: str, tables: Sequence[Table], before: Sequence[tuple[str, str]] = ()
) -> Path:
    """Write the tables as one HTML file; `before` are sections that stand above them."""
    sections = [*before]
    for table in tables:
        if table.rows:
            numbers = set(range(len(table.heads))) - set(table.left)
            sections.append((table.title, page_table(table.heads, table.rows, numbers)))
    return save_page(path, title, f"<p>{escape(verdict)}</p>", sections, "")


def _cut(*texts: str) -> list[str]:
    """Return texts as lines, of long ones what lies about the first place where they differ."""
    lines = [" ".join(text.split()) for text in texts]
    if max(map(len, lines)) > _LONGEST:
        alike = len([*takewhile(lambda letters: len({*letters}) == 1, zip(*lines, strict=False))])
        first = 1 + lines[0].rfind(" ", 0, max(0, alike - _BEFORE))
        lines = [f"... {line[first:]}" if first else line for line in lines]
    return [line if len(line) <= _LONGEST else line[: _LONGEST - 4] + " ..." for line in lines]


def _trace(change: TraceChange) -> tuple[str, ...]:
    if change.problem:
        return change.signal, change.unit, "", "", "", change.problem
    when = "" if change.first is None else f"{change.first:.9g} s"
    same = "same bits" if change.largest == 0.0 else "within the tolerance"
    numbers = (f"{change.largest:.3g}", f"{change.rms:.3g}") if change.largest else ("0", "0")
    return change.signal, change.unit, f"{change.rows:,}", *numbers, when or same


def _measure(change: MeasureChange) -> tuple[str, ...]:
    values = ["" if value is None else f"{value:.9g}" for value in (change.before, change.after)]
    moved = "" if change.before is None or change.after is None else f"{change.after - change.before:+.3g}"
    return change.name, change.unit, *values, moved, "" if change.same else "differs"


def _mean(change: MeanChange) -> tuple[str, ...]:
    low, high = change.interval
    interval = f"{low:+.3g} to {high:+.3g}"
    numbers = f"{change.before:.9g}", f"{change.after:.9g}", f"{change.difference:+.4g}", interval
    where = change.point, change.measure, change.unit, age_text(change.age)
    return *where, *numbers, f"{change.pairing:.3g}", "moved" if change.moved else ""


def _yield(change: YieldChange) -> tuple[str, ...]:
    parts = f"{change.before:.4g}", f"{change.after:.4g}", f"{change.probability:.2g}"
    age = "all" if change.age is None else age_text(change.age)
    return change.point, change.limit, age, *parts, "moved" if change.moved else ""
