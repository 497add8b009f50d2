"""Picture of a sigma-delta modulator: noise transfer function, signal to noise over amplitude."""

import math
from typing import TYPE_CHECKING

import numpy as np

from proofmass.runner.design.modulators.modulator import Modulator
from proofmass.runner.output.pictures import BLUE, INK, ORANGE, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_modulator(of: Modulator) -> "Figure":
    """Draw the noise's gain over frequency, and predicted and simulated ratios over amplitude."""
    with sheet(9.5, 3.6) as figure:
        left, right = figure.subplots(1, 2)
        low_pass = of.centre == 0.0
        frequencies = np.geomspace(0.01 / of.oversampling, 0.5, 2000) if low_pass else np.linspace(1e-4, 0.5, 2000)
        left.plot(frequencies, 20.0 * np.log10(np.maximum(np.abs(of.transfer.at(frequencies)), 1e-9)), color=BLUE)
        left.axvspan(*of.band, color=ORANGE, alpha=0.15, linewidth=0.0)
        scale = "log" if low_pass else "linear"
        left.set(xlabel="frequency / rate", ylabel="gain of the noise [dB]", xscale=scale)
        for ratios, style in ((of.predicted, {"color": INK}), (of.simulated, {"color": BLUE, "marker": "o"})):
            right.plot(of.amplitudes, [math.nan if ratio is None else ratio for ratio in ratios], **style)
        right.set(xlabel="amplitude [dB of full scale]", ylabel="signal to noise [dB]")
        right.legend(["predicted", "simulated"], loc="upper left")
    return figure
