"""Texts that the sections of the report of a study share, and one section for each point."""

import math
from collections.abc import Callable
from html import escape

from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.points import MOST_POINTS, all_points_text

Section = Callable[[StudyResult], str]


def at_each(points: Callable[[StudyResult], dict[str, StudyResult]]) -> Callable[[Section], Section]:
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


def ends_text(low: float, high: float) -> str:
    """Return an interval with as many digits as distinguish its ends.

    >>> ends_text(3275.8213, 3277.61), ends_text(1.0000464, 1.0000566)
    ('3275.82 to 3277.61', '1.000046 to 1.000057')
    >>> ends_text(-math.inf, 2.0), ends_text(1.0, math.inf)
    ('≤ 2', '≥ 1')
    """
    if math.isinf(low) or math.isinf(high):
        return f"≤ {high:.5g}" if math.isfinite(high) else f"≥ {low:.5g}" if math.isfinite(low) else "unknown"
    ratio = max(abs(low), abs(high)) / (high - low) if high > low else 1.0
    digits = min(15, max(5, math.ceil(math.log10(ratio)) + 2))
    return f"{low:.{digits}g} to {high:.{digits}g}"


def percent_text(part: float) -> str:
    """Return a part of a whole in percent, with enough digits to distinguish it from 0 % and from 100 %.

    >>> percent_text(0.204), percent_text(0.99987), percent_text(1.0)
    ('20.4 %', '99.99 %', '100 %')
    >>> percent_text(4e-4), percent_text(-1e-6)
    ('0.04 %', '0 %')
    """
    text = f"{100.0 * part:.1f} %"
    if text not in ("100.0 %", "0.0 %", "-0.0 %"):
        return text
    nearest = round(part)
    return f"{100 * nearest} %" if abs(part - nearest) < 5e-5 else f"{100.0 * part:.2f} %"
