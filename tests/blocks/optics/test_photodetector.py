"""The detector: its current, and shot and intensity noise against their densities."""

import math

import numpy as np
import pytest

from proofmass.blocks import Constant, Photodetector
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.functions import drive
from tests.by_hand.responses import response


def currents(block: Photodetector, power: float) -> np.ndarray:
    graph = Graph(
        name="light",
        rate="1 MHz",
        blocks={"light": Constant(value=power, unit="W"), "detector": block},
        wires=["light.output -> detector.power"],
        probes=["detector.current"],
        seed=3,
    )
    return simulate(graph, samples=20_000)["detector.current"].values


@pytest.mark.parametrize("relative", [0.0, 1e-13])
def test_noise_against_its_densities(relative: float) -> None:
    found = currents(Photodetector(intensity_noise=relative, dark_current=0.0), 10e-6)
    assert found.mean() == pytest.approx(9e-6, rel=1e-4)
    density = math.sqrt(2.0 * 1.602176634e-19 * 9e-6 + relative * 9e-6**2)
    assert found.std() == pytest.approx(density * math.sqrt(0.5e6), rel=0.02)


def test_without_noise_it_is_a_straight_line() -> None:
    block = Photodetector(responsivity=0.5, dark_current=2e-9, noisy=False)
    assert response(block, [4e-6, 0.0, -1e-6], "current", "power") == [
        pytest.approx(2.002e-6, rel=1e-15),
        2e-9,
        2e-9,
    ]


@pytest.mark.defect(
    "S675",
    before="intensity noise of the dark current too: 5.7 times the noise of 1 uA in the dark, at 1e-11 1/Hz",
    after="intensity noise of the light alone",
)
@pytest.mark.derivation(
    Photodetector,
    equation="s^2 = (2 e I + L^2 r) fs / 2, I = L + dark_current, L = responsivity power",
    source="Poisson's law of the electrons in a tick, and a light whose power wavers by r fs / 2 of its square",
    convention="one-sided densities, fs / 2 the band; s is rms; r is of power, not of the field, and of light alone",
    wrong="S675: the dark current had intensity noise too",
)
@pytest.mark.parametrize("power", [0.0, 2e-6])
def test_electrons_are_counted_and_light_wavers(power: float) -> None:
    charge, rate, dark, relative = 1.602176634e-19, 1e6, 1e-6, 1e-11
    light = 0.8 * power
    electrons = (light + dark) / rate / charge
    shot = charge * rate * math.sqrt(electrons)  # A: Poisson's deviation is the root of the mean
    wavering = light * math.sqrt(relative * rate / 2.0)
    block = Photodetector(responsivity=0.8, dark_current=dark, intensity_noise=relative)
    (row,) = drive(block, [{"power": power}], 1.0 / rate, normal=1.0)
    assert row["current"] - (light + dark) == pytest.approx(math.hypot(shot, wavering), rel=1e-9)
