"""The picture of a long spectrum has few lines, and every peak and notch."""

import numpy as np

from proofmass import spectrum
from proofmass.runner.analysis.spectrum.plot import plot_spectrum


def test_a_long_spectrum_is_drawn_by_its_lowest_and_highest_lines() -> None:
    found = spectrum(np.random.default_rng(7).normal(size=100_000), rate=1000.0, segment=0)
    frequencies, density = plot_spectrum(found).axes[0].lines[0].get_data()
    assert len(frequencies) < 0.1 * len(found.frequencies)
    lines = np.random.default_rng(8).integers(1, len(found.density) - 1, 200)
    for frequency, height in zip(found.frequencies[lines], found.amplitude_density[lines], strict=True):
        near = density[np.abs(np.log(frequencies / frequency)) < 0.01]  # less than a thousandth of the axis
        assert near.min() <= height <= near.max()
