"""The picture of a noise budget names what it draws, and says what is too small to be seen."""

import pytest

from proofmass import noise
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.analysis.noise.plot import plot_noise

GRAPH = read_graph(library_file("recorded_motion.toml"))


def legend(changes: dict[str, str]) -> list[str]:
    """What the legend of the budget says."""
    figure = plot_noise(noise(GRAPH.with_parameters(changes), "mean.mean", input="motion.output"))
    shown = figure.axes[0].get_legend()
    assert shown is not None
    return [text.get_text() for text in shown.get_texts()]


@pytest.mark.parametrize(
    ("changes", "names"),
    [
        ({}, ["amplifier (WhiteNoise)", "gas (WhiteNoise)", "adc (quantisation)", "all"]),
        (
            {"gas.density": "1e-30 N/sqrt(Hz)"},
            ["amplifier (WhiteNoise)", "adc (quantisation)", "all", "too small to see: gas"],
        ),
    ],
)
@pytest.mark.friendly(29, "legends have what is in the picture")
def test_the_legend_has_the_lines_that_are_in_the_picture(changes: dict[str, str], names: list[str]) -> None:
    assert legend(changes) == names
