"""The level of a source of noise from what a fit leaves of two outputs."""

import math

import pytest

from proofmass import Graph, ModelError, noise
from proofmass.blocks import BrownianForce, Constant, Gain, Sum, WhiteNoise
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


@pytest.mark.defect("S926", before="both levels took all that is left, 2.7 for 2 and twice the noise", after="refused")
def test_levels_of_one_output_are_not_told_apart() -> None:
    with pytest.raises(ModelError, match="is not determined beside the other levels"):
        list(noise_levels(GRAPH, ["hiss.density", "other.density"], {"noisy.output": (1e8, 100.0)}))
    with pytest.raises(ModelError, match="is not determined beside"):
        list(noise_levels(GRAPH, ["hiss.density"] * 2, {"noisy.output": (1e8, 100.0), "hiss.output": (1e3, 100.0)}))


@pytest.mark.defect("S926", before="a level beside another was found with that as it was before", after="together")
def test_levels_of_two_outputs_are_found_together() -> None:
    """Truths are 0.3 and 60: 500 Hz of 0.3^2, and of (100 * 0.3)^2 + 60^2."""
    left = {"hiss.output": (100.0 * 45.0, 100.0), "noisy.output": (100.0 * 500.0 * 4500.0, 100.0)}
    hiss, other = noise_levels(GRAPH, ["hiss.density", "other.density"], left)
    assert (hiss.value, other.value) == (pytest.approx(0.3, rel=1e-9), pytest.approx(60.0, rel=1e-9))
    assert (hiss.output, other.output) == ("hiss.output", "noisy.output")
    larger = math.sqrt(100.0 / 74.2219) - 1.0  # of chi-square with 100 degrees of freedom, from tables
    assert hiss.half_width == pytest.approx(0.3 * larger, rel=1e-5)
    wanted = math.hypot(4500.0 * larger, 1e4 * 0.09 * larger) / 60.0  # of 60^2 = 4500 - 100^2 * 0.3^2
    assert other.half_width == pytest.approx(wanted, rel=1e-5)


@pytest.mark.defect("S926", before="4 times the noise was that of twice the temperature", after="refused")
def test_what_noise_does_not_grow_in_proportion_to_is_no_level() -> None:
    graph = Graph(name="warm", rate=1000, blocks={"kick": BrownianForce()}, wires=[])
    (before,) = noise(graph, "kick.force").sources
    with pytest.raises(ModelError, match=r"kick\.temperature: is not a level of noise"):
        list(noise_levels(graph, ["kick.temperature"], {"kick.force": (400.0 * before.rms**2, 100.0)}))
