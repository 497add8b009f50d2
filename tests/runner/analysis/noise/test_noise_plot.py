"""The picture of a noise budget names what it draws, and says what is too small to be seen."""

import functools
from dataclasses import replace

import numpy as np
import pytest

from proofmass import noise
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.analysis.noise.noise_budget import NoiseBudget
from proofmass.runner.analysis.noise.plot import plot_noise

GRAPH = read_graph(library_file("recorded_motion.toml"))


@functools.cache
def budget(gas: str) -> NoiseBudget:
    """The budget of the library's recording, and with another noise of the gas."""
    graph = GRAPH.with_parameters({"gas.density": gas}) if gas else GRAPH
    return noise(graph, "mean.mean", input="motion.output")


@pytest.mark.parametrize(
    ("gas", "names"),
    [
        ("", ["amplifier (WhiteNoise)", "gas (WhiteNoise)", "adc (quantisation)", "all"]),
        (
            "1e-30 N/sqrt(Hz)",
            ["amplifier (WhiteNoise)", "adc (quantisation)", "all", "too small to see: gas"],
        ),
    ],
)
@pytest.mark.friendly(29, "legends have what is in the picture")
def test_the_legend_has_the_lines_that_are_in_the_picture(gas: str, names: list[str]) -> None:
    left, _ = plot_noise(budget(gas)).axes
    shown = left.get_legend()
    assert shown is not None
    assert [text.get_text() for text in shown.get_texts()] == names
    (every,) = [line for line in left.lines if line.get_label() == "all"]
    assert left.get_ylim()[1] == pytest.approx(2.0 * max(every.get_ydata()), rel=1e-12)


@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize("size", [1e-24, 1e24])
def test_lines_end_at_a_part_of_the_largest_amplitude(size: float) -> None:
    """At 1e-8 of it, whatever the unit: six of eleven amplitudes, each 10^-1.5 of the one before."""
    falling = size * 10.0 ** -(3.0 * np.arange(11.0))
    lines = 10.0 ** np.arange(-9.0, 2.0)
    left, *_ = plot_noise(replace(budget(""), input="", frequencies=lines, density=falling, sources=())).axes
    (every,) = [line for line in left.lines if line.get_label() == "all"]
    drawn = np.asarray(every.get_ydata(), dtype=float)
    assert drawn / drawn[0] == pytest.approx(10.0 ** -(1.5 * np.arange(6.0)), rel=1e-9)
