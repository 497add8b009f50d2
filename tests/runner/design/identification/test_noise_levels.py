"""The level of a source of noise from what a fit leaves of two outputs."""

import math

import pytest

from proofmass import Graph, ModelError
from proofmass.blocks import Constant, Gain, Sum, WhiteNoise
from proofmass.runner.design.identification.noise_levels import noise_levels

GRAPH = Graph(
    name="two outputs",
    rate=1000,
    blocks={
        "hiss": WhiteNoise(density=0.1),
        "louder": Gain(gain=100.0),
        "other": WhiteNoise(density=30.0),
        "noisy": Sum(),
        "level": Constant(value=1.0),
        "still": Gain(gain=1.0),
    },
    wires=[
        *("hiss.output -> louder.input", "louder.output -> noisy.first", "other.output -> noisy.second"),
        "level.output -> still.input",
    ],
)
OF_TWO = 500.0 * (100.0 + 900.0)  # V^2: in half the rate lie 500 Hz of (0.1 * 100)^2 and 30^2


@pytest.mark.defect("S750", before="no level where no noise reaches some output", after="the level, from the others")
def test_the_output_counts_of_which_it_makes_most() -> None:
    """Of one output it makes all, of a larger one a tenth, and of one without noise nothing."""
    left = {"still.output": (0.0, 100.0), "noisy.output": (100.0 * OF_TWO, 100.0), "hiss.output": (2000.0, 100.0)}
    (level,) = noise_levels(GRAPH, ["hiss.density"], left)
    assert (level.output, level.before) == ("hiss.output", 0.1)
    assert level.value == pytest.approx(math.sqrt(20.0 / 500.0), rel=1e-9)


def test_the_part_of_other_sources_is_taken_off() -> None:
    (level,) = noise_levels(GRAPH, ["hiss.density"], {"noisy.output": (100.0 * (OF_TWO + 150_000.0), 100.0)})
    assert level.value == pytest.approx(0.2, rel=1e-9)  # 500 * (20^2 + 30^2)
    with pytest.raises(ModelError, match="makes no noise"):
        list(noise_levels(GRAPH, ["other.density"], {"hiss.output": (1.0, 100.0)}))
    (none,) = noise_levels(GRAPH, ["hiss.density"], {"noisy.output": (100.0 * 449_999.0, 100.0)})
    assert (none.value, none.half_width) == (None, math.inf)
    with pytest.raises(ModelError, match="no noise reaches"):
        list(noise_levels(GRAPH, ["hiss.density"], {"still.output": (1.0, 100.0)}))
