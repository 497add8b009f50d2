"""Budgets of long common periods: the gathered directions against those of every random number, and a closed form."""

import numpy as np
import pytest

from proofmass import Graph, noise
from proofmass.blocks import AnalogToDigital, Decimator, Difference, DiscreteIntegrator, LowPass, WhiteNoise
from proofmass.runner.analysis.linearisation import period_map as module
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.derivatives.dual_noise import noise_blocks
from proofmass.runner.planning.plan import plan


def decimated(ratio: int) -> Graph:
    """A converter in a loop whose controller runs at a lower rate, behind a mean over many of its periods."""
    blocks = {
        "white": WhiteNoise(density=1e-3, unit="V"),
        "error": Difference(unit="V"),
        "filter": LowPass(corner_frequency=50.0, input_unit="V", output_unit="V"),
        "adc": AnalogToDigital(bits=12, reference=2.5),
        "control": DiscreteIntegrator(gain=3e-3, input_unit="1", output_unit="V"),
        "mean": Decimator(ratio=ratio),
    }
    wires = [
        "white.output -> error.first", "control.output -> error.second", "error.output -> filter.input",
        "filter.output -> adc.voltage", "adc.number -> control.input", "adc.number -> mean.input",
    ]  # fmt: skip
    return Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, rates={"control": "250 Hz"})


def test_the_same_map_either_way(monkeypatch: pytest.MonkeyPatch) -> None:
    planned = plan(decimated(100))
    node, noisy = node_of(planned, "mean.mean"), noise_blocks(planned)
    maps = []
    for many in (10**9, 64):
        monkeypatch.setattr(module, "_MANY", many)
        maps.append(module.period_map(planned, [], [node], noise=noisy, quantisers=noisy))
    plain, gathered = maps
    assert (plain.states, plain.inputs, plain.outputs) == (gathered.states, gathered.inputs, gathered.outputs)
    assert len(plain.inputs) == 200
    assert gathered.matrix == pytest.approx(plain.matrix, rel=1e-12, abs=1e-15 * np.max(np.abs(plain.matrix)))


@pytest.mark.exhaustive
def test_white_noise_behind_a_long_mean() -> None:
    """The mean of N independent values has a variance of one N-th."""
    ratio = 2000
    blocks = {"white": WhiteNoise(density=2.0), "mean": Decimator(ratio=ratio)}
    graph = Graph(name="", rate="1 kHz", blocks=blocks, wires=["white.output -> mean.input"])
    assert noise(graph, "mean.mean").rms ** 2 == pytest.approx(4.0 * 500.0 / ratio, rel=1e-12)
