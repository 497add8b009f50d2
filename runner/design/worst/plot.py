"""A picture of worst cases: what each parameter does alone, and how far all of them go together."""

import math
from collections.abc import Sequence
from textwrap import wrap
from typing import TYPE_CHECKING

from proofmass.blocks.declaration.shown_units import prefix
from proofmass.runner.design.worst.text import value_text
from proofmass.runner.design.worst.worst import OneAtATime, WorstCase, WorstCases
from proofmass.runner.output.pictures import BLUE, INK, ORANGE, axis_label, literal, name_rows, sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST = 15  # bars
_LEAST = 0.005  # of the longest bar: a shorter one cannot be seen
_LINE = 90  # characters below an axis


def plot_worst(cases: WorstCases) -> "Figure":
    """Draw a tornado for each quantity: ends of each parameter, and the worst of all together."""
    bars = [_bars(case) for case in cases.cases]
    heights = [1.5 + 0.27 * (len(own) + 1) for own in bars]
    with sheet(9.5, sum(heights)) as figure:
        panels = figure.subplots(len(bars), 1, squeeze=False, height_ratios=heights)[:, 0]
        for panel, case, own in zip(panels, cases.cases, bars, strict=True):
            _draw(panel, case, own)
    return figure


def _bars(case: WorstCase) -> list[OneAtATime]:
    """Return the parameters whose bars can be seen, the longest first."""
    reach = {single: _reach(case, single) for single in case.one_at_a_time}
    together = 0.0 if case.worst is None or case.nominal is None else abs(case.worst - case.nominal)
    least = _LEAST * max(filter(math.isfinite, [*reach.values(), together]), default=0.0)
    seen = [single for single, moves in reach.items() if moves > least]
    return sorted(seen, key=lambda single: -reach[single])[:_MOST]


def _reach(case: WorstCase, single: OneAtATime) -> float:
    """Return how far a parameter leads alone: without limit where an end has no finite value."""
    low, high, nominal = single.at_low, single.at_high, case.nominal or 0.0
    if low is None or high is None or not (math.isfinite(low) and math.isfinite(high)):
        return math.inf
    return max(abs(low - nominal), abs(high - nominal))


def _draw(panel: "Axes", case: WorstCase, bars: Sequence[OneAtATime]) -> None:
    if case.nominal is None or not math.isfinite(case.nominal):
        panel.set_title(
            f"{case.name}: {value_text(case.nominal, case, 'nominal')} at the nominal values", loc="left", size=10
        )
        panel.set_axis_off()
        return
    known = [v for v in (case.nominal, case.worst) if v is not None and math.isfinite(v)]
    factor, unit = prefix(case.quantity.unit, max(map(abs, known)))
    nominal = case.nominal * factor

    def reach(low: float | None, high: float | None) -> tuple[float, float]:
        ends = [nominal if end is None or not math.isfinite(end) else end * factor for end in (low, high)]
        return ends[0], ends[1]

    rows = [(single.parameter, *reach(single.at_low, single.at_high)) for single in bars]
    for place, (_, low, high) in enumerate(rows):
        panel.barh(place, low - nominal, left=nominal, color=ORANGE, height=0.6, label="low" if not place else None)
        panel.barh(place, high - nominal, left=nominal, color=BLUE, height=0.6, label="high" if not place else None)
    names = [name for name, _, _ in rows]
    if case.worst is not None and math.isfinite(case.worst):
        panel.barh(len(names), case.worst * factor - nominal, left=nominal, color=INK, height=0.6)
    panel.axvline(nominal, color=INK, linewidth=0.8)
    name_rows(panel, [*names, "all together"])
    if rows:
        panel.legend(loc="lower left", bbox_to_anchor=(0.75, 1.0), ncols=2)
    label = f" {unit}" if unit != "1" else ""
    worst = value_text(case.worst, case, "worst")
    if case.worst is not None and math.isfinite(case.worst):
        worst = f"{case.worst * factor:.5g}{label}"
    panel.set_title(f"{case.name}: {nominal:.5g}{label} nominal, {worst} at worst", loc="left", size=10)
    rest = [single.parameter for single in case.one_at_a_time if single.parameter not in names]
    lost = [single.parameter for single in bars if math.isinf(_reach(case, single))]
    notes = {"not drawn, too little alone": rest, "without a finite value at an end": lost}
    lines = [line for told, own in notes.items() if own for line in wrap(literal(f"{told}: {', '.join(own)}"), _LINE)]
    panel.set_xlabel("\n".join([axis_label(str(case.quantity), unit), *lines]))
