"""The spring: its force against a polynomial, and the swing of a mass on it against scipy and Duffing's frequency."""

import numpy as np
import pytest
from scipy import integrate, special

from proofmass.blocks import DuffingSpring, MassSpringDamper, Step, Sum
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.responses import noise, response

MASS, STIFFNESS, CUBIC, PUSH = 1e-3, 40.0, 900.0, 8.0


def test_against_a_polynomial() -> None:
    x = noise(100)
    block = DuffingSpring(linear=3.0, quadratic=-2.0, cubic=5.0)
    found = response(block, x, "force", "displacement")
    assert found == pytest.approx(np.polyval([-5.0, 2.0, -3.0, 0.0], x), rel=1e-12)


@pytest.mark.exhaustive
def test_a_mass_that_is_pushed_against_scipy() -> None:
    graph = Graph(
        name="hardening",
        rate="1 kHz",
        blocks={
            "push": Step(amplitude=PUSH, unit="N"),
            "forces": Sum(unit="N"),
            "mass": MassSpringDamper(mass=MASS, damping=0.01, stiffness=STIFFNESS),
            "spring": DuffingSpring(cubic=CUBIC),
        },
        wires=[
            "push.output -> forces.first",
            "spring.force -> forces.second",
            "forces.output -> mass.force",
            "mass.displacement -> spring.displacement",
        ],
        probes=["mass.displacement"],
        integration={"method": "dormand_prince", "accuracy": 1e-12},
    )
    found = simulate(graph, samples=100, engine="python")["mass.displacement"].values

    def moved(t: float, x: np.ndarray) -> list[float]:
        return [x[1], (PUSH - 0.01 * x[1] - STIFFNESS * x[0] - CUBIC * x[0] ** 3) / MASS]

    times = np.arange(100) * 1e-3
    exact = integrate.solve_ivp(moved, (0.0, 0.1), [0.0, 0.0], "DOP853", times, rtol=1e-12, atol=1e-14).y[0]
    assert np.abs(found - exact).max() < 1e-8 * np.abs(exact).max()


@pytest.mark.derivation(
    DuffingSpring,
    equation="F = -(k x + quadratic x^2 + cubic x^3); period 4 K(m) / sqrt((k + cubic A^2) / mass)",
    source="elliptic integral of the exact swing, and an integral of dx / v over the block's own force",
    convention="cubic is of the force, not of the energy; A is the peak; k is that of both springs together",
)
def test_its_force_gives_duffings_period() -> None:
    """4 K(m) / sqrt((k + c A^2) / mass), m = c A^2 / (2 (k + c A^2)): four times dx / v over a quarter."""
    amplitude = 0.2
    x = amplitude * np.sin(0.5 * np.pi * (np.arange(4000) + 0.5) / 4000)
    force = np.array(response(DuffingSpring(linear=STIFFNESS, cubic=CUBIC), x.tolist(), "force", "displacement"))
    energy = 0.5 * STIFFNESS * amplitude**2 + 0.25 * CUBIC * amplitude**4
    potential = 0.5 * STIFFNESS * x**2 + 0.25 * CUBIC * x**4
    assert np.gradient(potential, x)[5:-5] == pytest.approx(-force[5:-5], rel=1e-4)
    speed = np.sqrt(2.0 * (energy - potential) / MASS)
    quarter = np.sum(np.sqrt(amplitude**2 - x**2) / speed) * 0.5 * np.pi / 4000
    stiff = STIFFNESS + CUBIC * amplitude**2
    period = 4.0 * special.ellipk(CUBIC * amplitude**2 / (2.0 * stiff)) / np.sqrt(stiff / MASS)
    assert 4.0 * quarter == pytest.approx(period, rel=1e-6)
