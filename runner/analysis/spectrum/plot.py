"""Picture of a spectrum: amplitude density against frequency, its tones marked."""

from typing import TYPE_CHECKING

import numpy as np

from proofmass.runner.analysis.spectrum.tones import Tones
from proofmass.runner.analysis.spectrum.welch import Spectrum
from proofmass.runner.output.pictures import BLUE, INK, ORANGE, axis_label, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LINES = 4000  # drawn at most: each stretch of frequency by its lowest and highest line


def plot_spectrum(of: Spectrum, figures: Tones | None = None, band: tuple[float, float] | None = None) -> "Figure":
    """Amplitude density on logarithmic axes; tone, largest spur and band if any."""
    with sheet(9.0, 4.8, f"Spectral density of {of.name or 'the signal'}") as figure:
        panel = figure.subplots()
        lines = np.flatnonzero((of.frequencies > 0.0) & (of.density > 0.0))
        shown = _thinned(lines, of)
        panel.loglog(of.frequencies[shown], of.amplitude_density[shown], color=BLUE, linewidth=0.9)
        panel.set_xlabel("frequency [Hz]")
        panel.set_ylabel(axis_label("density", of.density_unit))
        panel.set_title(f"{of.window} window, {of.segments} segments of {of.segment:,} values", fontsize=9, pad=3)
        panel.margins(x=0.01)
        if band is not None:
            panel.axvspan(max(band[0], of.step / 2), min(band[1], of.rate / 2), color=BLUE, alpha=0.08, linewidth=0)
        if figures is not None:
            tone = figures.rms / np.sqrt(of.noise_bandwidth)
            panel.plot([figures.frequency], [tone], "o", color=ORANGE, markersize=5)
            text = f"tone {figures.frequency:.6g} Hz\nSNDR {figures.sndr:.1f} dB, ENOB {figures.enob:.2f}"
            panel.annotate(
                text, (figures.frequency, tone), (8, -6), textcoords="offset points", color=INK, fontsize=9, va="top"
            )
    return figure


def _thinned(
    lines: "np.ndarray[tuple[int], np.dtype[np.intp]]", of: Spectrum
) -> "np.ndarray[tuple[int], np.dtype[np.intp]]":
    """Lines to draw: where many fall on one place of the logarithmic axis, the lowest and the highest of them."""
    if len(lines) <= _LINES:
        return lines
    place = np.log(of.frequencies[lines])
    bins = ((place - place[0]) / (place[-1] - place[0]) * (_LINES // 2)).astype(int)
    starts = np.flatnonzero(np.diff(bins, prepend=-1))
    places = []
    for first, last in zip(starts, [*starts[1:], len(lines)], strict=True):
        values = of.density[lines[first:last]]
        places += sorted({int(first + np.argmin(values)), int(first + np.argmax(values))})
    return np.asarray(lines[np.array(places)])
