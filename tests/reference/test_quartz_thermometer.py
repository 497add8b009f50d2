"""The quartz thermometer of the gallery: every count by NumPy, from the phase of the beat."""

import math

import numpy as np
import pytest

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.run.simulate import simulate

GRAPH = read_graph(library_file("quartz_thermometer.toml"))
TICKS, RATE = 200_001, 1e6
ABOVE = 0.123  # K, so that no sample falls on a zero of the beat


def counts() -> list[float]:
    """Reciprocal counts of whole cycles, each begun by the edge that ended the one before, the first by rise two."""
    t = np.arange(TICKS) / RATE
    warming = np.where(t > 0.05, 2.0 * -np.expm1(-2.0 * math.pi * 15.9155 * (t - 0.05)), 0.0)
    beat = 28.2e6 * (1.0 + 35.4e-6 * (ABOVE + warming)) - 28.175e6
    turns = np.concatenate([[0.0], np.cumsum(beat)[:-1]]) / RATE
    high = np.sin(2.0 * math.pi * turns) >= 0.0
    edges = np.flatnonzero(high[1:] & ~high[:-1]) + 1
    found, begin = [], 1
    for number in range(2, len(edges)):
        if edges[number] - edges[begin] >= 10_000:
            found.append((number - begin) / (edges[number] - edges[begin]) * RATE)
            begin = number
    return found


def test_every_count() -> None:
    changed = {"instability.density": 0.0, "ambient.value": 298.15 + ABOVE}
    result = simulate(GRAPH.with_parameters(changed), samples=TICKS, engine="compiled")
    frequencies = result["counter.frequency"].values
    found = [frequencies[0], *frequencies[1:][np.diff(frequencies) != 0.0]]
    expected = counts()
    shown = [one for n, one in enumerate(expected) if n == 0 or one != expected[n - 1]]
    assert found[1:] == pytest.approx(shown, rel=1e-12)
    assert result["reading.output"].values[-1] == pytest.approx(300.15 + ABOVE, abs=3e-3)
