"""Sections of the report of a study on its years: when sensors leave their tolerances, and what calibrations buy."""

from collections.abc import Iterator
from html import escape

import numpy as np

from proofmass.blocks.declaration.shown_units import in_table
from proofmass.graphs.studies.ages import HOUR, YEAR, age_text, recalibration_text, some_of
from proofmass.runner.output.page import broken, picture, table
from proofmass.runner.studies.outcome.intervals import LEVEL, Bounds, concise, deviation_interval, mean_interval
from proofmass.runner.studies.outcome.lifetimes import OUT, Lifetimes, lifetimes
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.plot import plot_lifetimes
from proofmass.runner.studies.shown.points import parts, swept_parts
from proofmass.runner.studies.shown.report_sections import at_each, percent_text


@at_each(parts)
def lifetimes_section(result: StudyResult) -> str:
    """Return yield by age, survival and Weibull's law of each limit."""
    known: list[Lifetimes] = []
    parts_of_page = []
    for lives in lifetimes(result):
        alike = next((other.limit for other in known if _leave(lives) and _same(lives, other)), "")
        parts_of_page.append(f"<p>{escape(lives.limit)}: as {escape(alike)}.</p>" if alike else _of_limit(lives))
        known.append(lives)
    return "\n".join(parts_of_page)


def calibrations_section(result: StudyResult) -> str:
    """Return what the intervals between calibrations make of the same sensors, if several."""
    return _compared(result) if len(result.study.recalibration.every) > 1 else ""


def left_text(lives: Lifetimes, part: float) -> str:
    """Return when a part of the sensors has left its tolerance."""
    found = lives.left_at(part)
    if found is None:
        return f"not within {age_text(lives.ages[-1])}"
    return f"between {age_text(found[0])} and {age_text(found[1])}" if found[0] < found[1] else "when new"


def _of_limit(lives: Lifetimes) -> str:
    """Return the fate of the sensors under one limit in words, with pictures and a table if any has left it."""
    if not _leave(lives):
        return f"<p>{escape(_never_text(lives))}</p>"
    text = f"{lives.limit}: {_left_sentence(lives)}{_time_out_sentence(lives)}"
    if lives.law is not None:
        law = lives.law
        oldest, shape = lives.ages[-1], concise(law.shape, law.shape_interval)
        scale = _years(law.scale, law.scale_interval, oldest)
        one = _years(law.one_percent, law.one_percent_interval, oldest)
        text += f" Weibull's law has shape {shape} and scale {scale}; by it 1 % have left at {one}."
        text += "" if lives.law_fits else " It does not describe them: it leaves the band of the survival curve."
    shown = some_of(lives.ages)
    rows = [
        (age_text(age), _part(good, ends), _part(left, left_ends))
        for age, good, ends, left, left_ends in zip(
            lives.ages, lives.good, lives.good_intervals, lives.surviving, lives.surviving_intervals, strict=True
        )
        if age in shown
    ]
    heads = ("age", f"within limits ({100 * LEVEL:g} %)", f"never out ({100 * LEVEL:g} %)")
    drawing = picture(plot_lifetimes(lives), f"lifetimes of {lives.limit}")
    return f'<p>{escape(text)}</p>\n<div class="wide">{drawing}</div>{table(heads, rows, numbers=range(3))}'


def _same(lives: Lifetimes, other: Lifetimes) -> bool:
    return np.array_equal(lives.good, other.good) and np.array_equal(lives.surviving, other.surviving)


def _leave(lives: Lifetimes) -> bool:
    return bool((lives.surviving < 1.0).any())


def _never_text(lives: Lifetimes) -> str:
    low, _ = lives.surviving_intervals[-1]
    known = f"with {100 * LEVEL:g} % confidence at least {percent_text(low)} of all such sensors keep it"
    return f"{lives.limit}: no sensor left it within {age_text(lives.ages[-1])}; {known}."


def _left_sentence(lives: Lifetimes) -> str:
    """Return when parts of the sensors have left a limit: those of one span of ages together, the least first."""
    spans: dict[Bounds | None, list[float]] = {}
    for part in OUT:
        spans.setdefault(lives.left_at(part), []).append(part)
    told = [
        f"{' and then '.join(f'{100 * part:g} %' for part in parts)} of the sensors"
        f" {'left it' if span[0] < span[1] else 'were out of it'} {left_text(lives, parts[0])}"
        for span, parts in spans.items()
        if span
    ]
    kept = [
        f"fewer than {100 * part:g} % had left it at {age_text(lives.ages[-1])}" for part in spans.get(None, [])[:1]
    ]
    return "; ".join([*told, *kept]) + "."


def _time_out_sentence(lives: Lifetimes) -> str:
    if lives.time_out == 0.0:
        return ""
    low, high = lives.time_out_interval
    return (
        f" On average a sensor is out of it for {percent_text(lives.time_out)} of the time "
        f"({percent_text(max(low, 0.0))} to {percent_text(max(high, 0.0))})."
    )


@at_each(swept_parts)
def _compared(result: StudyResult) -> str:
    every = result.study.recalibration.every
    places = result.numbers % len(every)
    named = {recalibration_text(seconds): result.some(places == place) for place, seconds in enumerate(every)}
    named = {name: part for name, part in named.items() if len(part.numbers)}
    return "\n".join(filter(None, (_lives_table(named), _scatter_table(named))))


def _lives_table(named: dict[str, StudyResult]) -> str:
    lives = {name: {life.limit: life for life in lifetimes(part)} for name, part in named.items()}
    first = next(iter(named))

    def gain(name: str, limit: str) -> str:
        return "" if name == first else _gain(lives[name][limit], lives[first][limit], named[name], named[first])

    rows = [
        (
            name,
            broken(limit),
            _part(life.good[-1], life.good_intervals[-1]),
            left_text(life, OUT[0]),
            _part(life.time_out, life.time_out_interval),
            gain(name, limit),
        )
        for limit in lives[first]
        for name in named
        for life in (lives[name][limit],)
    ]
    if not rows:
        return ""
    oldest = age_text(next(iter(named.values())).study.epochs[-1])
    heads = ("calibrations", "limit", f"within it at {oldest}", "1 % have left", "time out of it", f"more than {first}")
    return table(heads, rows, numbers=(2, 4, 5))


def _gain(life: Lifetimes, base: Lifetimes, part: StudyResult, other: StudyResult) -> str:
    """Return how many more sensors are within the limit at the last age, each against itself."""
    _, mine, theirs = np.intersect1d(part.draws, other.draws, return_indices=True)
    apart = life.good_at_last[mine] - base.good_at_last[theirs]
    low, high = mean_interval(apart)
    return f"{100.0 * apart.mean():+.1f} % ({100.0 * low:.1f} to {100.0 * high:.1f} %)"


def _scatter_table(named: dict[str, StudyResult]) -> str:
    """Return the standard deviations of the measures at the last age, side by side."""

    def cells(measure: str) -> Iterator[str]:
        for part in named.values():
            values = part[measure][:, -1]
            values = values[np.isfinite(values)]
            yield concise(float(values.std(ddof=1)), deviation_interval(values)) if len(values) > 1 else ""

    first = next(iter(named.values()))
    rows = [(broken(m.name), in_table(m.unit), *cells(m.name)) for m in first.measures]
    heads = (f"standard deviation at {age_text(first.study.epochs[-1])}", "unit", *named)
    return table(heads, rows, numbers=range(2, len(heads)))


def _part(part: float, ends: Bounds) -> str:
    low, high = (min(max(end, 0.0), 1.0) for end in ends)
    return f"{percent_text(part)} ({percent_text(low)} to {percent_text(high)})"


def _years(age: float, ends: Bounds, oldest: float) -> str:
    """Return an age with its interval, in years or hours as the oldest age suits.

    >>> _years(2.0 * YEAR, (1.9 * YEAR, 2.1 * YEAR), YEAR), _years(3.6e6, (0.0, 7.2e6), 7.2e6)
    ('2 years (1.9 to 2.1)', '1000 h (0 to 2000)')
    """
    size, unit = (YEAR, "years") if oldest >= YEAR else (HOUR, "h")
    number, low, high = (f"{float(f'{seconds / size:.3g}'):g}" for seconds in (age, *ends))
    return f"{number} {unit} ({low} to {high})"
