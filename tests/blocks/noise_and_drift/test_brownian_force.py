"""The Brownian force: its density, and equipartition of the mass that it moves."""

import math

import numpy as np
import pytest
from scipy.constants import k

from proofmass.blocks import MassSpringDamper, WhiteNoise
from proofmass.blocks.noise_and_drift.brownian_force import BOLTZMANN, BrownianForce
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.functions import drive


def test_boltzmann() -> None:
    assert k == BOLTZMANN


@pytest.mark.parametrize("rate", [100.0, 1e6])
def test_white_with_the_density_of_the_theory(rate: float) -> None:
    density = math.sqrt(4.0 * k * 310.0 * 2e-5)
    force = drive(BrownianForce(damping=2e-5, temperature=310.0), [{}], period=1.0 / rate, normal=1.5)[0]["force"]
    white = drive(WhiteNoise(density=density, unit="N"), [{}], period=1.0 / rate, normal=1.5)[0]["output"]
    assert force == pytest.approx(white, rel=1e-14)


def test_half_a_boltzmann_energy_in_spring_and_motion() -> None:
    mass, damping, stiffness = 50e-9, 5e-4, 5.0  # 1.6 kHz, Q = 1
    graph = Graph(
        name="equipartition",
        rate=200_000,
        blocks={
            "gas": BrownianForce(damping=damping, temperature=300.0),
            "proof_mass": MassSpringDamper(mass=mass, damping=damping, stiffness=stiffness),
        },
        wires=["gas.force -> proof_mass.force"],
        probes=["proof_mass.displacement", "proof_mass.velocity"],
        seed=8,
    )
    result = simulate(graph, samples=2_000_000, engine="compiled")
    energies = (
        stiffness * np.mean(result["proof_mass.displacement"].values ** 2),
        mass * np.mean(result["proof_mass.velocity"].values ** 2),
    )
    independent = 10.0 * damping / mass  # 10 s, two relaxations of the energy each
    for energy in energies:
        assert energy / (k * 300.0) == pytest.approx(1.0, abs=4.0 * math.sqrt(2.0 / independent))
