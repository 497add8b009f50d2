"""Plot of an Allan deviation: the curve with its interval, and the slopes of the coefficients."""

from typing import TYPE_CHECKING

import numpy as np

from proofmass.runner.analysis.allan.deviations import Allan
from proofmass.runner.analysis.allan.field_units import field_unit, in_field_unit
from proofmass.runner.analysis.allan.freedom import AllanStatistic
from proofmass.runner.analysis.allan.levels import allan_terms
from proofmass.runner.output.pictures import BLUE, INK, ORANGE, axis_label, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_allan(allan: Allan) -> "Figure":
    """Overlapping Allan deviation with its interval of 95 %, the fit, and each coefficient seen."""
    curve = allan.curves[AllanStatistic.ALLAN]
    factor = in_field_unit("B", 1.0, allan.unit)
    with sheet(9.0, 5.2, f"Allan deviation of {allan.name or 'the signal'}") as figure:
        panel = figure.subplots()
        panel.fill_between(curve.taus, factor * curve.low, factor * curve.high, color=BLUE, alpha=0.2, linewidth=0)
        panel.loglog(curve.taus, factor * curve.deviation, color=BLUE, label="measured, 95 %")
        model = np.sqrt(allan.levels.variance(curve.taus))
        panel.loglog(curve.taus, factor * model, color=ORANGE, linewidth=1.0, label="N, B, K, Q fitted")
        bottom = 0.5 * factor * float(np.min(curve.low))
        terms = np.sqrt(allan_terms(curve.taus))
        for column, level in enumerate(allan.levels.levels):
            line = factor * level.value * terms[:, column]
            shown = line > bottom
            if level.seen and shown.any():
                panel.loglog(curve.taus[shown], line[shown], color=INK, linewidth=0.8, linestyle=":")
                place = int(np.flatnonzero(shown)[0 if level.name in "NQ" else -1])
                side = ("left", 6) if level.name in "NQ" else ("right", -6)
                panel.annotate(
                    level.name, (curve.taus[place], line[place]), (side[1], 3), ha=side[0], textcoords="offset points",
                    fontsize=9,
                )  # fmt: skip
        panel.set_ylim(bottom=bottom)
        panel.set_xlabel("averaging time [s]")
        panel.set_ylabel(axis_label("deviation", field_unit("B", allan.unit)))
        panel.margins(x=0.01)
        panel.legend(loc="best")
    return figure
