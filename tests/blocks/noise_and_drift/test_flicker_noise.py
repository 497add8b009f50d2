"""Flicker noise: the density that its filters make of white noise, against the line level^2 / f."""

import math

import numpy as np
import pytest
from scipy import signal

from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.noise_and_drift.flicker_noise import FlickerNoise, State, constants, poles, update
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.functions import drive


def density(block: FlickerNoise, rate: float, frequencies: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
    """One-sided power density of the deviation: the response to white noise, from the update of unit states."""
    c = constants(block, 1.0 / rate)
    order = 1 + poles(block.lowest_frequency, block.highest_frequency)

    def moved(state: np.ndarray, normal: float) -> tuple[list[float], float]:  # type: ignore[type-arg]
        slow = state[1:].tolist()
        after = update(c, State(0.0, state[0]), slow, normal)
        return [after.delayed, *slow], after.deviation

    a, row = (np.array(part) for part in zip(*(moved(unit, 0.0) for unit in np.eye(order)), strict=True))
    b, direct = moved(np.zeros(order), 1.0)
    z = np.exp(2j * math.pi * frequencies / rate)
    response = [row @ np.linalg.solve(at * np.eye(order) - a.T, np.array(b)) + direct for at in z]
    return 2.0 / rate * np.abs(response) ** 2


@pytest.mark.parametrize("lowest", [1e-3, 2e-3, 5e-3])
@pytest.mark.parametrize("highest", [1.0, 30.0, 100.0])
def test_within_0_04_decibel_below_a_tenth_of_the_rate(lowest: float, highest: float) -> None:
    frequencies = np.geomspace(lowest, highest, 200)
    block = FlickerNoise(level=3e-6, lowest_frequency=lowest, highest_frequency=highest)
    error = 10.0 * np.log10(density(block, 1000.0, frequencies) * frequencies / 9e-12)
    assert np.abs(error).max() < 0.04


@pytest.mark.parametrize("highest", [200.0, 400.0, 500.0, 700.0, 1000.0, 3000.0, 1e4, 1e6])
def test_within_0_16_decibel_up_to_half_of_the_rate(highest: float) -> None:
    frequencies = np.geomspace(1.0, min(highest, 500.0), 200)
    block = FlickerNoise(level=0.5, lowest_frequency=1.0, highest_frequency=highest)
    error = 10.0 * np.log10(density(block, 1000.0, frequencies) * frequencies / 0.25)
    assert np.abs(error).max() < 0.16


def test_ripple_of_0_015_decibel_inside_a_band_of_eleven_decades() -> None:
    frequencies = np.geomspace(1e-5, 1e3, 300)
    block = FlickerNoise(level=1.0, lowest_frequency=1e-7, highest_frequency=1e4)
    error = 10.0 * np.log10(density(block, 1e6, frequencies) * frequencies)
    assert np.abs(error).max() < 0.015


@pytest.mark.parametrize("highest", [1.01, 1.5, 3.0, 4.0, 4.1, 15.9, 16.1, 100.0, 1000.0])
def test_goes_on_below_the_band_for_two_octaves_and_is_flat_from_there(highest: float) -> None:
    block = FlickerNoise(level=0.3, lowest_frequency=5.0, highest_frequency=5.0 * highest)
    frequencies = 5.0 * np.array([1e-6, 1e-3, 1.0 / 32.0, 0.5])
    power = 10.0 * np.log10(density(block, 1000.0 * highest, frequencies) * 5.0 / 0.09)
    assert 7.5 < power[0] < 10.6
    assert power[0] - power[1:3] == pytest.approx([0.0, 0.105], abs=0.106)
    assert power[3] == pytest.approx(10.0 * math.log10(2.0), abs=0.3)  # as 1/f


def test_falls_above_the_band() -> None:
    block = FlickerNoise(level=1.0, lowest_frequency=1.0, highest_frequency=100.0)
    above = density(block, 1e6, np.array([1e4, 2e4]))
    assert above[0] / above[1] == pytest.approx(4.0, rel=0.05)


def test_spectrum_of_a_record() -> None:
    graph = Graph(
        name="flicker",
        rate=1000,
        blocks={"noise": FlickerNoise(level="2 ppm", lowest_frequency=0.1)},
        probes=["noise.deviation"],
        seed=2,
    )
    values = simulate(graph, samples=1_000_000, engine="compiled")["noise.deviation"].values
    frequencies, power = signal.welch(values, 1000.0, nperseg=1 << 14)
    for lowest, highest in ((1.0, 4.0), (4.0, 40.0), (40.0, 400.0)):
        inside = (frequencies > lowest) & (frequencies < highest)
        found = np.mean(power[inside] * frequencies[inside]) / 4e-12
        assert found == pytest.approx(1.0, abs=0.05 + 4.0 / math.sqrt(inside.sum() * 61.0))


def test_starts_at_the_nominal_value() -> None:
    rows = drive(FlickerNoise(level=0.1, nominal=5.0), [{}] * 3, period=1e-3, normal=1.0)
    assert rows[0] == {"value": 5.0, "deviation": 0.0}
    assert rows[2]["value"] == 5.0 * (1.0 + rows[2]["deviation"]) > 5.0


def test_as_many_poles_as_the_band_needs() -> None:
    assert [poles(1.0, high) for high in (1.1, 16.0, 17.0, 256.0, 1e15)] == [4, 5, 6, 7, 28]


@pytest.mark.parametrize("highest", [1e-3, 1e-4, 1e13])
def test_a_band_that_is_none_is_refused(highest: float) -> None:
    with pytest.raises(ModelError, match="above lowest_frequency, by 15 decades at most"):
        FlickerNoise(highest_frequency=highest)
