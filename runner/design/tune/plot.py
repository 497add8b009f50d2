"""Picture of a tuning: parameters in bounds, how far goals are met, loops before and after."""

import math
from typing import TYPE_CHECKING

import numpy as np

from proofmass.blocks.declaration.shown_units import in_print
from proofmass.graphs.model.loops import AUTO
from proofmass.graphs.model.quantities import LoopFigure
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.linearisation.linearise import one_loop
from proofmass.runner.analysis.linearisation.phase import counted_phase
from proofmass.runner.analysis.margins.frequencies import sweep
from proofmass.runner.design.tune.tune import Tuned
from proofmass.runner.output.pictures import BLUE, GRID, INK, ORANGE, PAPER, name_rows, phase_ticks, sheet
from proofmass.runner.planning.plan import plan

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_LOOPS = 2


def plot_tuned(tuned: Tuned) -> "Figure":
    """Draw parameters and goals above, the first loops below."""
    quantities = [goal.goal.quantity for goal in tuned.goals]
    loops = list(dict.fromkeys(q.loop for q in quantities if isinstance(q, LoopFigure)))[:_MOST_LOOPS]
    rows = max(len(tuned.parameters), len(tuned.goals))
    top = 1.2 + 0.36 * rows
    title = "all hard goals are met" if tuned.met else "hard goals are missed"
    with sheet(10.5, top + 4.2 * len(loops), title) as figure:
        grid = figure.add_gridspec(1 + 2 * len(loops), 2, height_ratios=[top, *[2.1] * (2 * len(loops))])
        _draw_parameters(tuned, figure.add_subplot(grid[0, 0]))
        _draw_goals(tuned, figure.add_subplot(grid[0, 1]))
        for number, loop in enumerate(loops):
            size = figure.add_subplot(grid[1 + 2 * number, :])
            _draw_loop(tuned, loop, size, figure.add_subplot(grid[2 + 2 * number, :], sharex=size))
    return figure


def _draw_parameters(tuned: Tuned, panel: "Axes") -> None:
    free = tuned.tuning.free
    for place, (name, value) in enumerate(tuned.parameters.items()):
        before, after = (free[name].part(v) for v in (tuned.before[name], value))
        panel.plot([0.0, 1.0], [place, place], color=GRID, linewidth=5.0, solid_capstyle="round", zorder=1)
        panel.plot(
            before, place, "o", markerfacecolor=PAPER, color=INK, zorder=2, label="before" if not place else None
        )
        panel.plot(after, place, "o", color=BLUE, zorder=3, label="after" if not place else None)
        for part, bound, side in ((0.0, free[name].at_least, "left"), (1.0, free[name].at_most, "right")):
            panel.annotate(
                in_print(bound, tuned.tuning.unit_of(name)),
                (part, place),
                (0, 7),
                textcoords="offset points",
                ha=side,
                size=8,
            )
    name_rows(panel, [tuned.tuning.written.get(name, name) for name in tuned.parameters])
    panel.set_xticks([])
    panel.grid(visible=False)
    panel.set_title("parameters between their bounds", loc="left", size=10)
    panel.legend(loc="lower center", bbox_to_anchor=(0.5, -0.2), ncols=2)


def _draw_goals(tuned: Tuned, panel: "Axes") -> None:
    """Draw by how much each goal is over its limit, or better than before, in per cent."""
    names, values, colours = [], [], []
    for goal in tuned.goals:
        if goal.after is None:
            continue
        if goal.goal.limits:
            sign, limit = min(goal.goal.limits, key=lambda pair: pair[0] * (goal.after - pair[1]))  # type: ignore[operator]
            value = 100.0 * sign * (goal.after - limit) / (abs(limit) or 1.0)
        elif goal.before:
            value = 100.0 * (goal.after - goal.before) / abs(goal.before) * (-1.0 if goal.goal.minimise else 1.0)
        else:
            continue
        names.append(f"{goal.name}{' (binds)' if goal.binds else ''}")
        values.append(min(value, 200.0))
        colours.append(BLUE if value >= -1e-6 else ORANGE)
    panel.barh(range(len(names)), values, color=colours, height=0.6)
    panel.axvline(0.0, color=INK, linewidth=0.8)
    name_rows(panel, names)
    panel.set_xlabel("better than the limit, or than before [%]")
    panel.set_title("goals", loc="left", size=10)


def _draw_loop(tuned: Tuned, loop: str, size: "Axes", phase: "Axes") -> None:
    for graph, colour, label in ((tuned.tuning.graph, INK, "before"), (tuned.graph, BLUE, "after")):
        planned = plan(graph.changed(probes=()))
        system = OperatingPoints(planned, tuned.tuning.at or AUTO).loop(one_loop(planned, loop)[1])
        w = sweep(system)
        response = system.response(w)
        frequency, style = w / (2.0 * math.pi), "--" if label == "before" else "-"
        size.plot(frequency, 20.0 * np.log10(np.abs(response)), style, color=colour, label=label)
        phase.plot(frequency, np.degrees(counted_phase(system.response, w, response)), style, color=colour)
    size.axhline(0.0, color=INK, linewidth=0.8)
    size.set_xscale("log")
    size.set_ylabel("|L| [dB]")
    size.set_title(f"loop {loop}", loc="left", size=10)
    size.legend(loc="upper right")
    phase_ticks(phase)
    size.set_xlabel("frequency [Hz]")
    phase.set_ylabel("phase of L [deg]")
    phase.set_xlabel("frequency [Hz]")
