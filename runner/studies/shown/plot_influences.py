"""Picture of the influences on a measure: a tornado of the factors, and scatter plots of the strongest."""

from typing import TYPE_CHECKING

from proofmass.blocks.declaration.libraries import need
from proofmass.blocks.declaration.shown_units import pretty
from proofmass.runner.output.plot import BLUE, INK, ORANGE, PAPER, STYLE
from proofmass.runner.run.result import Array
from proofmass.runner.studies.draws.factors import Factors
from proofmass.runner.studies.shown.sensitivities import Influence, Regression

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BARS = 12
_SCATTERS = 2
_POINTS = 2000


def plot_influences(factors: Factors, regression: Regression, values: Array, label: str) -> "Figure":
    """Bars of the effects of a standard deviation with their intervals, strongest on top; scatter of the first runs."""
    need("matplotlib")
    # start-up time: matplotlib takes 0.3 s, and most callers draw nothing
    import matplotlib
    from matplotlib.figure import Figure

    strongest = regression.influences[:_BARS]
    with matplotlib.rc_context(STYLE):
        height = max(3.2, 1.0 + 0.28 * len(strongest))
        figure = Figure(figsize=(9.0, height), facecolor=PAPER, layout="constrained")
        drawn = strongest[:_SCATTERS]
        tornado, *scatters = figure.subplots(1, 1 + len(drawn), width_ratios=[1.4] + [1.0] * len(drawn))
        _draw_tornado(tornado, regression, label)
        for panel, influence in zip(scatters, drawn, strict=True):
            first = influence.parameters[0]
            panel.plot(factors.columns[first][:_POINTS], values[:_POINTS], ".", color=BLUE, markersize=3, alpha=0.6)
            unit = pretty(factors.units[first])
            panel.set_xlabel(first + (f" [{unit}]" if unit != "1" else ""))
            panel.ticklabel_format(useOffset=False)
            panel.tick_params(axis="x", labelrotation=30)
        if scatters:
            scatters[0].set_ylabel(label)
    return figure


def _draw_tornado(panel: "Axes", regression: Regression, label: str) -> None:
    bars = regression.influences[:_BARS][::-1]
    effects = [influence.effect for influence in bars]
    colours = [BLUE if effect >= 0.0 else ORANGE for effect in effects]
    halves = [influence.effect_half for influence in bars]
    names = [_short(influence) for influence in bars]
    panel.barh(names, effects, color=colours, height=0.6, xerr=halves, error_kw={"ecolor": INK, "elinewidth": 0.8})
    panel.set_ylim(min(-0.5, 0.5 * len(bars) - 2.0), max(len(bars) - 0.5, 0.5 * len(bars) + 1.0))  # no fat bars
    panel.axvline(0.0, color=INK, linewidth=0.8)
    panel.set_xlabel(f"{label} for one standard deviation")


def _short(influence: Influence) -> str:
    """Return the first parameter of a factor, and how many move with it."""
    first, *others = influence.parameters
    return f"{first}\nand {len(others)} with it" if others else first
