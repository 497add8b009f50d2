"""A picture of a fit to recordings: outputs with runs, what is left, its autocorrelation."""

from typing import TYPE_CHECKING

import numpy as np

from proofmass.blocks.declaration.shown_units import prefix
from proofmass.runner.design.identification.fitted import Fitted
from proofmass.runner.output.pictures import BLUE, INK, ORANGE, axis_label, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST = 4  # outputs that are drawn
_CLOSE = 120  # rows that are drawn closer
_ROWS = 4000  # of a curve; of longer recordings this many rows are drawn


def plot_fitted(fitted: Fitted) -> "Figure":
    """Draw the longest recording of each output."""
    outputs = fitted.outputs[:_MOST]
    with sheet(10.5, 3.6 * len(outputs) + 0.4) as figure:
        grid = figure.add_gridspec(2 * len(outputs), 3, height_ratios=[2.2, 1.4] * len(outputs))
        for number, output in enumerate(outputs):
            places = [i for i, r in enumerate(fitted.recordings) if output.signal in r.outputs]
            place = max(places, key=lambda i: len(fitted.recordings[i].times))
            recording, run = fitted.recordings[place], fitted.modelled[place][output.signal]
            measured, times = recording.outputs[output.signal], recording.times
            every = slice(None, None, max(1, len(times) // _ROWS))
            size, second = prefix("s", float(times[-1]) if len(times) else 0.0)
            times = size * times
            factor, unit = prefix(output.unit, float(np.nanmax(np.abs(measured))) or 1.0)
            upper = figure.add_subplot(grid[2 * number, :2])
            upper.plot(times[every], measured[every] * factor, ".", markersize=2.5, color=ORANGE)
            upper.plot(times[every], run[every] * factor, color=BLUE)
            upper.set_ylabel(axis_label(output.signal, unit))
            upper.set_title(f"{output.signal}: {100.0 * output.explained:.4g} % explained", loc="left", size=10)
            closer = figure.add_subplot(grid[2 * number, 2])
            middle = max(0, len(times) // 2 - _CLOSE // 2)
            part = slice(middle, middle + _CLOSE)
            closer.plot(times[part], measured[part] * factor, ".", markersize=4.0, color=ORANGE, label="recorded")
            closer.plot(times[part], run[part] * factor, color=BLUE, label="fitted")
            closer.set_title("closer", loc="left", size=10)
            closer.legend(loc="lower center", bbox_to_anchor=(0.6, 1.0), ncols=2)
            lower = figure.add_subplot(grid[2 * number + 1, :2], sharex=upper)
            factor, unit = prefix(output.unit, float(np.nanmax(np.abs(run - measured))) or 1.0)
            lower.plot(times[every], (run - measured)[every] * factor, ".", markersize=2.5, color=INK)
            lower.set_ylabel(axis_label("residual", unit))
            for below in (closer, lower):
                below.set_xlabel(f"time [{second}]")
            panel = figure.add_subplot(grid[2 * number + 1, 2])
            test = output.whiteness
            limit = 1.96 / np.sqrt(max(len(times), 1))
            panel.axhspan(-limit, limit, color="#e4eef5")
            panel.bar(np.arange(1, len(test.autocorrelation) + 1), test.autocorrelation, color=BLUE, width=0.6)
            panel.axhline(0.0, color=INK, linewidth=0.8)
            panel.set_xlabel("lag [rows]")
            found = "white" if test.white else "not white"
            if not len(test.autocorrelation):
                panel.set(xticks=(), yticks=())
                found = "nothing is left"
            panel.set_title(f"autocorrelation: {found}", loc="left", size=10)
    return figure
