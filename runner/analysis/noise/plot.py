"""Picture of a noise budget: the density of each source and of all, and the Allan deviation that it makes."""

from typing import TYPE_CHECKING, Any

import numpy as np

from proofmass.runner.analysis.allan.field_units import field_unit, in_field_unit
from proofmass.runner.analysis.noise.noise_budget import NoiseBudget
from proofmass.runner.output.pictures import COLOURS, INK, axis_label, literal, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NAMED = 2  # sources in one line of the legend
_LEAST = 1e-8  # of the total density, below which nothing is drawn


def plot_noise(budget: NoiseBudget) -> "Figure":
    """Amplitude densities, at the input where there is one, and beside them the Allan deviation."""
    unit = budget.referred_unit
    place = f"{budget.output}, referred to {budget.input}" if budget.input else budget.output
    with sheet(11.0, 4.8, f"Noise of {place}") as figure:
        left, right = figure.subplots(1, 2, width_ratios=(3, 2))
        sources = [source for source in budget.sources if source.rms > 0.0]
        for colour, source in zip(COLOURS, sources, strict=False):
            _draw(left, budget, source.density, color=colour, label=literal(f"{source.block} ({source.kind})"))
        unseen = [literal(source.block) for source in sources[len(left.lines) :]]
        _draw(left, budget, budget.density, color=INK, linewidth=1.6, label="all")
        top = in_field_unit("density", 1.0, unit) * float(np.sqrt(np.max(budget.referred_density)))
        left.set_ylim(bottom=max(left.get_ylim()[0], top * _LEAST**0.5), top=2.0 * top)
        for line in [*left.lines]:
            if np.max(np.asarray(line.get_ydata()), initial=0.0) <= left.get_ylim()[0]:
                unseen.append(str(line.get_label()).partition(" (")[0])
                line.remove()
        if unseen:
            more = f" and {len(unseen) - _NAMED} more" if len(unseen) > _NAMED else ""
            left.plot([], [], linestyle="none", label=f"too small to see: {', '.join(unseen[:_NAMED])}{more}")
        left.set_xlabel("frequency [Hz]")
        left.set_ylabel(axis_label("density", field_unit("density", unit)))
        left.legend(loc="best")
        taus, deviation = budget.allan()
        right.loglog(taus, in_field_unit("B", 1.0, unit) * deviation, color=INK)
        right.set_title("Allan deviation", fontsize=9, pad=3)
        right.set_xlabel("averaging time [s]")
        right.set_ylabel(axis_label("deviation", field_unit("B", unit)))
        for panel in (left, right):
            panel.margins(x=0.01)
    return figure


def _draw(panel: Any, budget: NoiseBudget, density: Any, **style: Any) -> None:
    referred = density / np.abs(budget.gain) ** 2 if budget.input else density
    factor = in_field_unit("density", 1.0, budget.referred_unit)
    shown = referred > _LEAST**2 * np.max(referred, initial=0.0)
    panel.loglog(budget.frequencies[shown], factor * np.sqrt(referred[shown]), **style)
