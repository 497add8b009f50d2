"""Loops through a quantiser of one bit: its gain, against a modulator written by hand, and the margins that follow."""

from collections.abc import Mapping, Sequence

import numpy as np
import pytest

import proofmass
from proofmass.blocks import (
    Comparator,
    Constant,
    Decimator,
    Difference,
    DiscreteIntegrator,
    Gain,
    Negation,
    Sum,
    WhiteNoise,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.quantities import LoopFigure
from proofmass.runner.design.quantities.evaluator import Evaluator

RATE, DC = 10_000.0, 0.123456789


def modulator(
    density: float,
    more: Mapping[str, Block] | None = None,
    wired: Sequence[str] = ("dc.output -> input.first",),
    rates: Mapping[str, float] | None = None,
) -> Graph:
    """First order: y' = y + u - v, v = sign of y, with noise at the input; and more blocks."""
    blocks: dict[str, Block] = {
        "dc": Constant(value=DC),
        "noise": WhiteNoise(density=density),
        "input": Sum(),
        "error": Difference(),
        "sum": DiscreteIntegrator(gain=RATE, output_unit="1"),
        "bit": Comparator(),
        "back": Gain(),
    }
    wires = [*wired, "noise.output -> input.second", "input.output -> error.first"]
    wires += ["back.output -> error.second", "error.output -> sum.input", "sum.output -> bit.input"]
    blocks, wires = blocks | dict(more or {}), [*wires, "bit.sign -> back.input"]
    return Graph(name="", rate=RATE, duration="2 s", blocks=blocks, wires=wires, rates=rates or {})


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


@pytest.mark.defect("S984", before="no value in `worst`, `tune` and within tolerances", after="as `margins`")
@pytest.mark.exhaustive
def test_a_search_takes_the_gain_of_the_run_too() -> None:
    """Twice 1 / K ends at -1."""
    figure = LoopFigure("back.output", "gain_margin", "dB")
    reading = Evaluator(modulator(0.01), {"margin": figure}, "", {}).readings({}, slopes=False)["margin"]
    assert reading is not None
    assert reading.value == pytest.approx(20.0 * np.log10(2.0 / by_hand(0.01 * np.sqrt(RATE / 2.0))), abs=0.4)


@pytest.mark.defect("S873", before="a gain margin of 8.99", after="10")
@pytest.mark.exhaustive
def test_a_slow_loop_around_a_modulator() -> None:
    """Means of 100 decisions, one period late, are integrated: L = k / (z (z - 1)), abs(L) = 1 where 2 sin(w/2) = k."""
    ratio, k = 100, 0.1
    blocks: dict[str, Block] = {"mean": Decimator(ratio=ratio), "minus": Negation(), "plus": Sum()}
    blocks["control"] = DiscreteIntegrator(gain=k * RATE / ratio, output_unit="1")
    wires = ["bit.sign -> mean.input", "mean.mean -> control.input", "control.output -> minus.input"]
    wires += ["minus.output -> plus.first", "dc.output -> plus.second"]
    graph = modulator(0.02, blocks, [*wires, "plus.output -> input.first"], {"control": 100.0, "minus": 100.0})
    found = proofmass.margins(graph, "minus.output")
    w = 2.0 * np.arcsin(k / 2.0)
    assert found.gain_margin == pytest.approx(1.0 / k, rel=1e-3)
    assert found.phase_margin == pytest.approx(0.5 * np.pi - 1.5 * w, abs=4e-3)


def test_a_converter_of_more_bits_has_a_gain_of_its_own() -> None:
    found = proofmass.margins("library:closed_loop_accelerometer")
    assert not any("one bit" in note for note in found.system.map.notes)
