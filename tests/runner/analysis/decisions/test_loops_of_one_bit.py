"""Loops through a quantiser of one bit: its gain, against a modulator written by hand, and the margins that follow."""

import numpy as np
import pytest

import proofmass
from proofmass.blocks import Comparator, Constant, Difference, DiscreteIntegrator, Gain, Sum, WhiteNoise
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph

RATE, DC = 10_000.0, 0.123456789


def modulator(density: float) -> Graph:
    """First order: y' = y + u - v, v = sign of y, with noise at the input."""
    blocks: dict[str, Block] = {
        "dc": Constant(value=DC),
        "noise": WhiteNoise(density=density),
        "input": Sum(),
        "error": Difference(),
        "sum": DiscreteIntegrator(gain=RATE, output_unit="1"),
        "bit": Comparator(),
        "back": Gain(),
    }
    wires = ["dc.output -> input.first", "noise.output -> input.second", "input.output -> error.first"]
    wires += ["back.output -> error.second", "error.output -> sum.input", "sum.output -> bit.input"]
    return Graph(name="", rate=RATE, duration="2 s", blocks=blocks, wires=[*wires, "bit.sign -> back.input"])


def by_hand(sigma: float, count: int = 200_000) -> float:
    """What the noise of some ticks before does to v, over what it does to y."""
    noise = np.random.default_rng(5).normal(size=count)
    y, rows = 0.0, np.empty((count, 2))
    for tick, by in enumerate((sigma * noise).tolist()):
        v = 1.0 if y >= 0.0 else -1.0
        rows[tick] = y, v
        y += DC + by - v
    does = np.array([noise[:-lag] @ (rows[lag:] - rows.mean(axis=0)) for lag in range(1, 9)])
    return float(does[:, 0] @ does[:, 1] / (does[:, 0] @ does[:, 0]))


@pytest.mark.defect("S802", before="ended with a mismatch of matrices", after="has the margins of its gain")
@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize("density", [0.01, 0.002])
def test_the_margin_is_that_of_the_gain_of_the_run(density: float) -> None:
    """L = K / (z - 1): twice 1 / K ends at -1, and the wire is stable from any lower gain on."""
    found = proofmass.margins(modulator(density), "back.output")
    K = by_hand(density * np.sqrt(RATE / 2.0))
    assert found.stable
    assert found.gain_margin == pytest.approx(2.0 / K, rel=0.05)
    assert found.gain_reduction is None
    (note,) = [note for note in found.system.map.notes if "one bit counts as a gain" in note]
    assert note.startswith("bit: ")


def test_a_converter_of_more_bits_has_a_gain_of_its_own() -> None:
    found = proofmass.margins("library:closed_loop_accelerometer")
    assert not any("one bit" in note for note in found.system.map.notes)
