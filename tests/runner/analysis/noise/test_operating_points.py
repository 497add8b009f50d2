"""Operating points of noise budgets: without noise, however late."""

import math

import pytest

from proofmass import noise
from proofmass.blocks import Gain, Product, Ramp, Sine, Sum, WhiteNoise
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.noise.budget import budgets_at
from proofmass.runner.planning.plan import plan


@pytest.mark.defect("S21", before="about a noisy state after 20,000 ticks", after="noise is zero, however late")
def test_a_late_operating_point_has_no_noise() -> None:
    """y = x + 50 x^2 about x = 0 passes on the noise as it is; about a noisy x it would not."""
    blocks: dict[str, Block] = {
        "x": WhiteNoise(density=1e-3),
        "square": Product(),
        "large": Gain(gain=50.0),
        "y": Sum(),
    }
    wires = ["x.output -> square.first", "x.output -> square.second", "square.output -> large.input"]
    wires += ["x.output -> y.first", "large.output -> y.second"]
    graph = Graph(name="bent", rate=10_000, blocks=blocks, wires=wires, probes=["y.output"])
    for at in ("0.1 s", "3 s", "settled"):
        budget = noise(graph, "y.output", at=at, frequencies=[10.0])
        assert math.sqrt(budget.density[0]) == pytest.approx(1e-3, rel=1e-9), at


@pytest.mark.exhaustive("1250")
@pytest.mark.defect("S32", before="about one tick of a slow carrier", after="about its period")
@pytest.mark.parametrize("ticks", [125, 1250])
def test_a_carrier_of_many_ticks(ticks: int) -> None:
    """Noise that a slow carrier multiplies has half its mean square."""
    rate = 10_000.0
    blocks: dict[str, Block] = {
        "x": WhiteNoise(density=1e-3),
        "carrier": Sine(frequency=rate / ticks),
        "y": Product(),
    }
    wires = ["x.output -> y.first", "carrier.output -> y.second"]
    graph = Graph(name="slow", rate=rate, blocks=blocks, wires=wires, probes=["y.output"])
    budget = noise(graph, "y.output", at="periodic")
    assert budget.rms == pytest.approx(1e-3 * math.sqrt(0.25 * rate), rel=1e-9)
    assert budget.period == pytest.approx(ticks / rate)


def test_what_is_slower_still_is_told() -> None:
    blocks: dict[str, Block] = {"x": WhiteNoise(density=1e-3), "slow": Sine(frequency=0.01), "y": Product()}
    wires = ["x.output -> y.first", "slow.output -> y.second"]
    graph = Graph(name="slow", rate=10_000.0, blocks=blocks, wires=wires, probes=["y.output"])
    assert "while slow.output moves on" in noise(graph, "y.output", at="periodic").notes[0]


@pytest.mark.defect(
    "S854", before="of two outputs, one's end of the run is the other's too", after="each its own point"
)
def test_an_output_has_the_point_that_it_has_alone() -> None:
    """The ramp moves the first product for good; the second does not read it."""
    blocks: dict[str, Block] = {
        "x": WhiteNoise(density=1e-3),
        "ramp": Ramp(offset=1.0, slope=2.0),
        "sine": Sine(frequency=250.0),
        "moving": Product(),
        "turning": Product(),
    }
    wires = [f"x.output -> {product}.first" for product in ("moving", "turning")]
    wires += ["ramp.output -> moving.second", "sine.output -> turning.second"]
    graph = Graph(name="two", rate=1_000.0, duration="0.5 s", blocks=blocks, wires=wires)
    outputs = ["moving.output", "turning.output"]
    moving, turning = budgets_at(OperatingPoints(plan(graph)), outputs)
    assert "the end of the run" in moving.notes[0]
    alone = noise(graph, outputs[1])
    assert (turning.rms, turning.notes) == (alone.rms, alone.notes)
