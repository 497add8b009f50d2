"""Densities of maps with states that are gone after a period: A holds rounding of them, and no unit."""

import math
from fractions import Fraction

import numpy as np
import pytest

from proofmass import Graph, noise
from proofmass.blocks import Comparator, Gain, InPhaseQuadratureDemodulator, Notch, Sine, Switch, WhiteNoise
from proofmass.runner.analysis.linearisation.open_loop import TransferMatrix
from proofmass.runner.analysis.noise.noise_map import NoiseMap
from proofmass.runner.derivatives.dual_noise import DEVIATE

VALUES, PERIOD = 6, 0.12


def switched_notch() -> Graph:
    """Demodulated noise through a notch, of which a switch takes the negative in some ticks: 120 ms are a period."""
    blocks = {
        "hiss": WhiteNoise(density=8e-5),
        "sine": Sine(frequency=125.0),
        "cosine": Sine(frequency=125.0, phase=0.5 * math.pi),
        "mixer": InPhaseQuadratureDemodulator(corner_frequency=13.6812, unit="1"),
        "band": Notch(frequency=69.0698, quality=1.0841),
        "gain": Gain(gain=-1.7234),
        "carrier": Sine(frequency=100.0, phase=5.2),
        "on": Comparator(threshold=-0.1),
        "switch": Switch(),
    }
    wires = ["hiss.output -> mixer.signal", "sine.output -> mixer.sine", "cosine.output -> mixer.cosine"]
    wires += ["mixer.in_phase -> band.input", "band.output -> gain.input", "gain.output -> switch.first"]
    wires += ["band.output -> switch.second", "carrier.output -> on.input", "on.on -> switch.choose_first"]
    rates = {"hiss": 500, "on": 500, "band": 250, "carrier": 250, "switch": 250, "gain": Fraction(1000, 3)}
    return Graph(name="switched notch", rate=1000, blocks=blocks, wires=wires, rates=rates, duration="2 s")


@pytest.mark.exhaustive("1 s")
@pytest.mark.defect("S826", before="37 times too much", after="those whose integral is the mean square")
@pytest.mark.parametrize("at", ["0 s", "1 s"])
def test_densities_add_up_to_the_mean_square(at: str) -> None:
    """Even frequencies integrate a density exactly that is a polynomial of a few hundred degrees in their cosines."""
    count = 1024
    f = (np.arange(count) + 0.5) * 125.0 / count
    budget = noise(switched_notch(), "switch.output", at=at, frequencies=f.tolist())
    assert float(np.mean(budget.density)) * 125.0 == pytest.approx(budget.rms**2, rel=1e-6)


def forgetful(seed: int) -> tuple[np.ndarray, ...]:
    """Return A, B, C and D with two states that others move, and that a period forgets but for rounding."""
    rng = np.random.default_rng(seed)
    a = np.zeros((4, 4))
    a[:, 2:] = 0.01 * rng.normal(size=(4, 2))
    a[:2, :2] = 10.0 ** -rng.uniform(15.0, 40.0) * rng.normal(size=(2, 2))
    return a, rng.normal(size=(4, 3)), rng.normal(size=(VALUES, 4)), rng.normal(size=(VALUES, 3))


@pytest.mark.defect("S826", before="off by up to 1e+37", after="by 1e-13")
@pytest.mark.parametrize("seed", range(10))
def test_a_density_and_a_response_are_those_of_a_linear_solution(seed: int) -> None:
    a, b, c, d = forgetful(seed)
    f = np.linspace(0.1, 20.0, 16)
    z = np.exp(2j * np.pi * f * PERIOD)
    direct = np.array([c @ np.linalg.solve(place * np.eye(4) - a, b) + d for place in z])
    assert TransferMatrix(a, b, c, d)(z) == pytest.approx(direct, rel=1e-11, abs=1e-12)
    turns = np.exp(-2j * np.pi * np.outer(f, np.arange(VALUES)) * PERIOD / VALUES)
    power = np.abs(np.einsum("fi,fik->fk", turns, direct)) ** 2
    entries = tuple(("hiss", DEVIATE, number) for number in range(3))
    found = NoiseMap((a, b, c, d), PERIOD, entries, {}).densities(f)[:, 0]
    assert found == pytest.approx(power.sum(axis=1) * 2.0 * PERIOD / VALUES**2, rel=1e-11)
