"""Picture of a fit: the readings with all models on top, what each leaves below."""

from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np

from proofmass.blocks.declaration.shown_units import prefix
from proofmass.runner.design.fit.fit import Fit, FitReport
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.output.pictures import COLOURS, INK, axis_label, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_DASHES = ("-", "--", ":", "-.")
_DOTS = 4000  # readings drawn


def plot_fit(report: FitReport) -> "Figure":
    """A figure with a panel for readings and models and one for the residuals of each model, on one scale."""
    readings = report.readings
    drawn = np.unique(np.linspace(0, len(readings.output) - 1, _DOTS).astype(int))
    order = np.argsort(readings.temperature, kind="stable")
    fits = [fit for fit in report.fits if fit.method != "alternation"]
    factor, unit = prefix(readings.output_unit, float(np.abs(readings.output).max()))
    finer, fine_unit = prefix(readings.output_unit, max(float(np.abs(fit.residual).max()) for fit in fits))
    with sheet(9.0, 4.2 + 1.3 * len(fits)) as figure:
        panels = figure.subplots(1 + len(fits), sharex=True, height_ratios=[2.6] + [1.0] * len(fits))
        top = panels[0]
        top.plot(*_dots(readings.temperature, readings.output * factor, drawn), color=INK, label="readings")
        for fit, colour, dashes in zip(fits, cycle(COLOURS), cycle(_DASHES), strict=False):
            model = (readings.output - fit.residual) * factor
            top.plot(readings.temperature[order], model[order], color=colour, linestyle=dashes, label=fit.model)
        top.set_ylabel(axis_label(readings.output_name, unit))
        top.legend()
        top.set_title(f"{readings.source}: {report.before * factor:.4g} {unit} peak to peak".rstrip(), weight="bold")
        largest = 1.1 * max(float(np.abs(fit.residual).max()) for fit in fits) * finer or 1.0
        for panel, fit, colour in zip(panels[1:], fits, cycle(COLOURS), strict=False):
            panel.axhline(0.0, color=INK, linewidth=0.8)
            panel.plot(*_dots(readings.temperature, fit.residual * finer, drawn), color=colour)
            panel.set_ylim(-largest, largest)
            panel.set_ylabel(axis_label("residual", fine_unit))
            panel.set_title(_measured(fit, finer, fine_unit), fontsize=9, loc="left", pad=3)
        panels[-1].set_xlabel(axis_label(readings.temperature_name, readings.temperature_unit))
    return figure


def _dots(x: AnyArray, y: AnyArray, drawn: AnyArray) -> tuple[AnyArray, AnyArray, str]:
    return x[drawn], y[drawn], "."


def _measured(fit: Fit, factor: float, unit: str) -> str:
    numbers = f"RMSE {fit.rmse * factor:.4g} {unit}, {fit.after * factor:.4g} {unit} peak to peak"
    return f"{fit.model}: {numbers}, R² {fit.r_squared:.5f}".replace(" ,", ",")
