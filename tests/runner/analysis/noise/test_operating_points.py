"""Operating points of noise budgets: without noise, however late."""

import math

import pytest

from proofmass import noise
from proofmass.blocks import Gain, Product, Sum, WhiteNoise
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph


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
