"""The Gauss-Markov process: its recursion, and mean, variance and correlation of a long record."""

import math

import numpy as np
import pytest

from proofmass.blocks import GaussMarkov
from proofmass.blocks.arithmetic.counter_random import normal_deviate
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.functions import drive


def test_decays_exponentially_from_a_settled_start() -> None:
    block = GaussMarkov(standard_deviation=0.25, correlation_time=2.0, nominal=10.0)
    rows = drive(block, [{}] * 3, period=0.5, normal=2.0)
    a = math.exp(-0.25)
    step = 0.25 * math.sqrt(1.0 - a * a) * 2.0
    expected = [0.5, a * 0.5 + step, a * (a * 0.5 + step) + step]
    assert [row["deviation"] for row in rows] == pytest.approx(expected, rel=1e-14)
    assert [row["value"] for row in rows] == pytest.approx([10.0 * (1.0 + d) for d in expected], rel=1e-14)


def test_starts_at_the_nominal_value_when_told() -> None:
    rows = drive(GaussMarkov(standard_deviation=1.0, stationary=False), [{}] * 2, normal=1.0)
    assert rows[0]["deviation"] == 0.0
    assert rows[1]["deviation"] > 0.0


@pytest.mark.parametrize("correlation_time", [1e-9, 1e12])
def test_the_extremes_are_white_noise_and_a_random_walk(correlation_time: float) -> None:
    block = GaussMarkov(standard_deviation=3.0, correlation_time=correlation_time, stationary=False)
    second = drive(block, [{}] * 3, normal=1.0)[2]["deviation"]
    white, walk = 3.0, 2.0 * 3.0 * math.sqrt(2.0 / correlation_time)
    assert second == pytest.approx(white if correlation_time < 1.0 else walk, rel=1e-11)


def test_settled_from_the_first_tick() -> None:
    graph = Graph(
        name="settled",
        rate=10,
        blocks={f"walk_{i}": GaussMarkov(standard_deviation=2.0, correlation_time=1e6) for i in range(200)},
        probes=[f"walk_{i}.deviation" for i in range(200)],
    )
    result = simulate(graph, samples=1, engine="python")
    first = np.array([result[name].values[0] for name in result])
    assert np.std(first) == pytest.approx(2.0, rel=4.0 / math.sqrt(400.0))
    assert normal_deviate(0, 0, 0, 0) not in first


def test_variance_and_correlation() -> None:
    graph = Graph(
        name="correlation",
        rate=100,
        blocks={"process": GaussMarkov(standard_deviation="30 ppm", correlation_time=0.1)},
        probes=["process.deviation"],
        seed=5,
    )
    values = simulate(graph, samples=1_000_000, engine="compiled")["process.deviation"].values / 30e-6
    independent = len(values) / 20.0  # a value every two correlation times
    assert abs(values.mean()) < 4.0 / math.sqrt(independent)
    for lag in (0, 3, 10, 30):
        found = np.mean(values[: len(values) - lag] * values[lag:])
        assert found == pytest.approx(math.exp(-lag / 10.0), abs=4.0 * math.sqrt(2.0 / independent))
