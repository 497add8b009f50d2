"""Notes where noise is not small, against the moments of a square and in a linear graph."""

import math

import numpy as np
import pytest

from proofmass import Graph, noise, simulate
from proofmass.blocks import (
    AnalogToDigital,
    Constant,
    Delay,
    Gain,
    LowPass,
    Product,
    Saturation,
    Sum,
    UnitDelay,
    WhiteNoise,
)
from proofmass.runner.analysis.linearisation.linearisation import linearised
from proofmass.runner.analysis.noise.noise_map import NoiseMap, noise_map
from proofmass.runner.analysis.noise.validity import difference_squared
from proofmass.runner.derivatives.dual_noise import noise_blocks
from proofmass.runner.planning.plan import plan


def squared(constant: float) -> Graph:
    """The square of a constant and noise of 1 V rms, through a filter that hardly filters."""
    blocks = {
        "white": WhiteNoise(density=math.sqrt(2e-3), unit="V"),
        "constant": Constant(value=constant, unit="V"),
        "sum": Sum(unit="V"),
        "filter": LowPass(corner_frequency=400.0, input_unit="V", output_unit="V"),
        "square": Product(first_unit="V", second_unit="V"),
    }
    wires = [
        "white.output -> sum.first", "constant.output -> sum.second", "sum.output -> filter.input",
        "filter.output -> square.first", "filter.output -> square.second",
    ]  # fmt: skip
    return Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, probes=["square.output", "filter.output"])


@pytest.mark.parametrize(("constant", "small"), [(0.01, False), (100.0, True)])
def test_the_square_of_noise(constant: float, small: bool) -> None:
    """Of x + n with n of variance v it has the variance 4 x^2 v + 2 v^2, of which a budget knows the first."""
    graph = squared(constant)
    budget = noise(graph, "square.output", at="0.1 s")
    assert (not any("noise is not small" in note for note in budget.notes)) == small
    values = simulate(graph, samples=20_000)["square.output"].values[100:]
    assert (abs(np.std(values) / budget.rms - 1.0) < 0.1) == small


def test_a_linear_graph_has_no_note() -> None:
    assert noise(squared(0.01), "filter.output", at="0.1 s").notes == ()


@pytest.mark.defect(
    "S872", before="noise is not small: the same noise moves the output otherwise, by 120 %", after="no note"
)
def test_a_delay_line_has_no_note() -> None:
    """Two paths of one noise, one 4 ticks late: 1 + 0.49 times the mean square of 1."""
    blocks = {
        "white": WhiteNoise(density=math.sqrt(2e-3), unit="V"),
        "late": Delay(ticks=4, unit="V"),
        "less": LowPass(corner_frequency=1e5, gain=-0.7, input_unit="V", output_unit="V"),
        "sum": Sum(unit="V"),
    }
    wires = [
        "white.output -> late.input", "white.output -> less.input", "late.output -> sum.first",
        "less.output -> sum.second",
    ]  # fmt: skip
    budget = noise(Graph(name="", rate="1 kHz", blocks=blocks, wires=wires), "sum.output")
    assert budget.notes == ()
    assert budget.rms == pytest.approx(math.sqrt(1.49), rel=1e-9)


def through(corner: float) -> NoiseMap:
    """White noise through a filter."""
    blocks = {
        "white": WhiteNoise(density=1e-3, unit="V"),
        "filter": LowPass(corner_frequency=corner, input_unit="V", output_unit="V"),
    }
    graph = Graph(name="", rate="1 kHz", blocks=blocks, wires=["white.output -> filter.input"])
    planned, target = plan(graph), ("filter", "output")
    return noise_map(linearised(planned).map([], [target], noise=noise_blocks(planned)), target)


def test_the_difference_of_two_filters_of_one_noise() -> None:
    """Against the integral of |H1 - H2|^2 over frequency, by a fine sum."""
    first, second = through(50.0), through(20.0)
    f = (np.arange(20_000) + 0.5) / 20_000 * 500.0
    real, imaginary = np.split(first.heard(f) - second.heard(f), 2)
    apart = (real**2 + imaginary**2) @ first.variances * 2.0 * first.period
    assert difference_squared(first, second) == pytest.approx(float(np.mean(apart)) * 500.0, rel=1e-6)
    assert abs(difference_squared(first, first)) < 1e-12 * float(sum(first.mean_squares))


@pytest.mark.defect("S799", before="noted by chance, at one instant; never without a memory", after="noted")
@pytest.mark.parametrize("filtered", [False, True])
def test_a_converter_that_noise_fills(filtered: bool) -> None:
    """Noise of 20 V is beyond 4 V for 84 % of the time: what comes out is never more."""
    blocks = {
        "white": WhiteNoise(density=math.sqrt(2e-3) * 20.0, unit="V"),
        "filter": LowPass(corner_frequency=400.0, input_unit="V", output_unit="V"),
        "adc": AnalogToDigital(bits=12, reference=4.0),
    }
    wires = (
        ["white.output -> filter.input", "filter.output -> adc.voltage"]
        if filtered
        else ["white.output -> adc.voltage"]
    )
    if not filtered:
        del blocks["filter"]
    graph = Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, probes=["adc.number"])
    budget = noise(graph, "adc.number")
    values = np.asarray(simulate(graph, samples=2_000)["adc.number"].values)
    assert np.std(values) < 0.6 * budget.rms
    assert any("noise is not small" in note for note in budget.notes)


@pytest.mark.defect(
    "S1080", before="0.45 rms of what is 1.08 in a run, without a note", after="a loop is unstable on the way"
)
def test_noise_that_takes_a_loop_off_its_limit() -> None:
    """x[n + 1] = 1.2 clip(x[n]) + w rests at 1.2, where it forgets all: but noise takes it to -1.2 and back."""
    blocks = {
        "white": WhiteNoise(density=0.45 * math.sqrt(2e-3)),
        "kick": Constant(value=0.01),
        "clip": Saturation(lowest=-1.0, highest=1.0),
        "gain": Gain(gain=1.2),
        "late": UnitDelay(),
        "pushed": Sum(),
        "sum": Sum(),
    }
    wires = ["late.output -> clip.input", "clip.output -> gain.input", "gain.output -> sum.first"]
    wires += ["white.output -> pushed.first", "kick.output -> pushed.second", "pushed.output -> sum.second"]
    wires += ["sum.output -> late.input"]
    graph = Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, probes=["sum.output"])
    budget = noise(graph, "sum.output", at="0.2 s")
    assert budget.rms == pytest.approx(0.45, rel=1e-9)
    assert any("a loop is unstable; a study of many runs" in note for note in budget.notes)
    assert np.std(simulate(graph, samples=100_000)["sum.output"].values) > 2.0 * budget.rms
