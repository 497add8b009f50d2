"""Allan deviations of white noise, flicker noise and random walk: slopes -1/2, 0 and 1/2, and their coefficients."""

import math
from functools import cache

import numpy as np
import pytest

from proofmass.blocks import FlickerNoise, RandomWalk, WhiteNoise
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate

RATE, SAMPLES, SEEDS = 1000, 2_000_000, (1, 2)
AVERAGED = np.array([16 << octave for octave in range(8)])  # ticks: 2.1 decades of tau
TAU = AVERAGED / RATE
WHITE, FLICKER, WALK = 0.02, 3e-6, 5e-6  # white: density 0.02 sqrt(2)


def overlapping_allan_variance(values: np.ndarray, averaged: int) -> float:  # type: ignore[type-arg]
    """Half the mean square of the differences of neighbouring means, at every start (IEEE Std 1139)."""
    sums = np.cumsum(np.concatenate(([0.0], values)))
    second = sums[2 * averaged :] - 2.0 * sums[averaged:-averaged] + sums[: -2 * averaged]
    return float(np.mean(second * second)) / (2.0 * averaged**2)


@cache
def allan_deviations() -> dict[str, np.ndarray]:  # type: ignore[type-arg]
    """Of each noise at every tau, the variances averaged over the seeds."""
    graph = Graph(
        name="three noises",
        rate=RATE,
        blocks={
            "white": WhiteNoise(density=WHITE * math.sqrt(2.0)),
            "flicker": FlickerNoise(level=FLICKER, lowest_frequency=1e-4, highest_frequency=1e3),
            "walk": RandomWalk(coefficient=WALK),
        },
        probes=["white.output", "flicker.deviation", "walk.deviation"],
    )
    found = {probe.signal.split(".")[0]: np.zeros(len(AVERAGED)) for probe in graph.probes}
    for seed in SEEDS:
        result = simulate(graph, samples=SAMPLES, seed=seed, engine="compiled")
        for signal in result:
            variances = [overlapping_allan_variance(result[signal].values, m) for m in AVERAGED]
            found[signal.split(".")[0]] += np.array(variances) / len(SEEDS)
    return {name: np.sqrt(variances) for name, variances in found.items()}


def test_allan_variance_by_hand() -> None:
    values = np.array([1.0, 4.0, 2.0, 2.0])
    assert overlapping_allan_variance(values, 1) == pytest.approx((9.0 + 4.0 + 0.0) / 3.0 / 2.0)
    assert overlapping_allan_variance(values, 2) == pytest.approx(0.5**2 / 2.0)


@pytest.mark.exhaustive
@pytest.mark.parametrize(("noise", "slope"), [("white", -0.5), ("flicker", 0.0), ("walk", 0.5)])
def test_slopes(noise: str, slope: float) -> None:
    weights = 1.0 / np.sqrt(AVERAGED)  # the more means in the record, the surer
    found, _ = np.polyfit(np.log(TAU), np.log(allan_deviations()[noise]), 1, w=weights)
    assert found == pytest.approx(slope, abs=0.02)


@pytest.mark.exhaustive
def test_coefficients() -> None:
    measured = allan_deviations()
    expected = {
        "white": WHITE / np.sqrt(TAU),
        "flicker": FLICKER * math.sqrt(2.0 * math.log(2.0)) * np.ones(len(TAU)),
        "walk": WALK * np.sqrt(TAU / 3.0 * (1.0 + 0.5 / AVERAGED**2)),  # of a walk in steps
    }
    deviation = 1.0 / np.sqrt(2.0 * len(SEEDS) * SAMPLES / AVERAGED)  # relative, of an estimate
    for noise, values in expected.items():
        assert np.all(np.abs(measured[noise] / values - 1.0) < 4.0 * deviation + 0.005), noise
