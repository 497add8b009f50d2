"""The picture of a noise budget names what it draws, and says what is too small to be seen."""

import pytest

from proofmass import noise
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.analysis.noise.plot import plot_noise

GRAPH = read_graph(library_file("recorded_motion.toml"))


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
    left, _ = plot_noise(noise(GRAPH.with_parameters(changes), "mean.mean", input="motion.output")).axes
    shown = left.get_legend()
    assert shown is not None
    assert [text.get_text() for text in shown.get_texts()] == names
    (every,) = [line for line in left.lines if line.get_label() == "all"]
    assert left.get_ylim()[1] == pytest.approx(2.0 * max(every.get_ydata()), rel=1e-12)
