"""A picture of worst cases: what each parameter does alone, and how far all of them go together."""

import math
from typing import TYPE_CHECKING

from proofmass.blocks.declaration.shown_units import prefix
from proofmass.runner.design.worst.worst import WorstCase, WorstCases
from proofmass.runner.output.pictures import BLUE, INK, ORANGE, axis_label, name_rows, sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST = 15  # bars


def plot_worst(cases: WorstCases) -> "Figure":
    """Draw a tornado for each quantity: both ends of each parameter alone, and the worst of all together."""
    bars = min(len(cases.ranges), _MOST)
    height = 1.5 + 0.27 * (bars + 1)
    with sheet(9.5, height * len(cases.cases)) as figure:
        panels = figure.subplots(len(cases.cases), 1, squeeze=False)[:, 0]
        for panel, case in zip(panels, cases.cases, strict=True):
            _draw(panel, case)
    return figure


def _draw(panel: "Axes", case: WorstCase) -> None:
    known = [v for v in (case.nominal, case.worst) if v is not None and math.isfinite(v)]
    factor, unit = prefix(case.quantity.unit, max(map(abs, known), default=1.0))
    if case.nominal is None or not math.isfinite(case.nominal):
        panel.set_title(f"{case.name}: unstable at the nominal values", loc="left", size=10)
        panel.set_axis_off()
        return
    nominal = case.nominal * factor

    def reach(low: float | None, high: float | None) -> tuple[float, float]:
        ends = [nominal if end is None or not math.isfinite(end) else end * factor for end in (low, high)]
        return ends[0], ends[1]

    rows = [(single.parameter, *reach(single.at_low, single.at_high)) for single in case.one_at_a_time]
    rows.sort(key=lambda row: -max(abs(row[1] - nominal), abs(row[2] - nominal)))
    for place, (_, low, high) in enumerate(rows[:_MOST]):
        panel.barh(place, low - nominal, left=nominal, color=ORANGE, height=0.6, label="low" if not place else None)
        panel.barh(place, high - nominal, left=nominal, color=BLUE, height=0.6, label="high" if not place else None)
    names = [name for name, _, _ in rows[:_MOST]]
    if case.worst is not None and math.isfinite(case.worst):
        panel.barh(len(names), case.worst * factor - nominal, left=nominal, color=INK, height=0.6)
    panel.axvline(nominal, color=INK, linewidth=0.8)
    name_rows(panel, [*names, "all together"])
    panel.legend(loc="lower left", bbox_to_anchor=(0.75, 1.0), ncols=2)
    label = f" {unit}" if unit != "1" else ""
    worst = "unstable" if case.worst is None else f"{case.worst * factor:.5g}{label}"
    panel.set_title(f"{case.name}: {nominal:.5g}{label} nominal, {worst} at worst", loc="left", size=10)
    panel.set_xlabel(axis_label(str(case.quantity), unit))
