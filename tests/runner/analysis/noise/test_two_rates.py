"""A loop of two rates, and a user's own noise, against the covariance of the loop written out by hand."""

import numpy as np
import pytest

from proofmass.blocks import DiscreteIntegrator, Gain, Sum, UnitDelay, WhiteNoise
from proofmass.blocks.declaration.declare import Block, param
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.noise.budget import noise
from proofmass.runner.analysis.response.response import response

RATIO, LEAK, GAIN = 3, 0.9, 0.02


def loop() -> Graph:
    """A leaky fast state, driven by noise, and a slow integrator that reads it each third tick and acts on it."""
    blocks = {
        "w": WhiteNoise(density=np.sqrt(2.0 / 1000.0)),  # of variance 1 a tick
        "v": WhiteNoise(density=np.sqrt(2.0 / (1000.0 / RATIO))),
        "x": UnitDelay(),
        "leak": Gain(gain=LEAK),
        "sum": Sum(),
        "read": Sum(),
        "slow": DiscreteIntegrator(gain=GAIN * 1000.0 / RATIO, output_unit="1"),
        "back": Gain(gain=-1.0),
    }
    wires = [
        "x.output -> leak.input", "leak.output -> sum.first", "w.output -> sum.second", "back.output -> sum.third",
        "sum.output -> x.input", "x.output -> read.first", "v.output -> read.second", "read.output -> slow.input",
        "slow.output -> back.input",
    ]  # fmt: skip
    slow = dict.fromkeys(("v", "read", "slow", "back"), "")
    return Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, rates=dict.fromkeys(slow, "1000/3 Hz"))


def mean_square_by_hand() -> tuple[float, float]:
    """Mean over a period of the mean square of x, by w and by v, once the covariance repeats itself."""
    fast = np.array([[LEAK, 0.0, -1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])  # of x, the integral, and what it holds
    slow = np.array([[LEAK, -1.0, 0.0], [GAIN, 1.0, 0.0], [0.0, 1.0, 0.0]])
    by_w, by_v = np.array([[1.0], [0.0], [0.0]]), np.array([[0.0], [GAIN], [0.0]])
    found = []
    for entry, ticks in ((by_w, range(RATIO)), (by_v, range(1))):
        p, squares = np.zeros((3, 3)), [0.0] * RATIO
        for _ in range(4000):
            for tick in range(RATIO):
                squares[tick] = p[0, 0]
                a = slow if tick == 0 else fast
                p = a @ p @ a.T + (entry @ entry.T if tick in ticks else 0.0)
        found.append(float(np.mean(squares)))
    return found[0], found[1]


def test_two_rates() -> None:
    budget = noise(loop(), "x.output")
    by_source = {source.block: source.rms**2 for source in budget.sources}
    by_w, by_v = mean_square_by_hand()
    assert by_source["w"] == pytest.approx(by_w, rel=1e-9)
    assert by_source["v"] == pytest.approx(by_v, rel=1e-9)


def test_an_unstable_loop_is_refused() -> None:
    graph = loop()
    fast = graph.with_parameters({"slow.gain": 20.0 * GAIN * 1000.0 / RATIO})
    with pytest.raises(ModelError, match="grows without end"):
        noise(fast, "x.output")


def test_the_integral_of_the_density_is_the_mean_square() -> None:
    whole, banded = noise(loop(), "x.output"), noise(loop(), "x.output", band=(0.0, 500.0))
    assert banded.rms == pytest.approx(whole.rms, rel=1e-10)


class Popcorn(Block):
    """Noise of a user's own: products of deviates are none, but a deviate with a memory is."""

    spread: float = param("1", "Standard deviation.", default=1.0)


@Popcorn.output("1")
def output(p: Popcorn, normal: float) -> float:
    """Half of what WhiteNoise of the same deviation gives."""
    return 0.5 * p.spread * normal


def test_a_block_of_the_users_own_takes_part() -> None:
    graph = Graph(
        name="", rate="1 kHz", blocks={"own": Popcorn(spread=3.0), "o": Gain()}, wires=["own.output -> o.input"]
    )
    budget = noise(graph, "o.output")
    assert [(source.block, source.kind) for source in budget.sources] == [("own", "Popcorn")]
    assert budget.rms == pytest.approx(1.5, rel=1e-12)


@pytest.mark.defect(
    "S1100",
    before="the gain of a budget, whose output ticks 2 ms after its input, had the phase of one without clock offsets",
    after="its phase is that of `response`, and of a delay by hand",
)
def test_clock_offsets_turn_the_gain_of_a_budget() -> None:
    blocks = {"w": WhiteNoise(), "slow": Gain(gain=3.0)}
    graph = Graph(
        name="",
        rate="1 kHz",
        blocks=blocks,
        wires=["w.output -> slow.input"],
        rates={"w": "200 Hz", "slow": "200 Hz"},
        offsets={"slow": "2 ms"},
    )
    f = np.array([1.0, 30.0, 80.0])
    budget = noise(graph, "slow.output", input="w.output", frequencies=f.tolist())
    assert budget.gain == pytest.approx(3.0 * np.exp(-2j * np.pi * f * 2e-3), rel=1e-12)
    assert budget.gain == pytest.approx(response(graph, "w.output", "slow.output", frequencies=f).gain, rel=1e-12)
