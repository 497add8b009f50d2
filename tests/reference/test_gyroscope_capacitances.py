"""The gyroscope with the capacitances of table 2 of Sarraf et al. 2012 against closed forms of both modes."""

import math

import pytest

from docs.papers.pn_runs import library
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate

MASS, DRIVE, SENSE, DAMPING = 48.67e-9, 122.28, 132.23, 57e-6
C_SENSE, GAP = 0.6e-12, 2e-6
OMEGA = math.sqrt(DRIVE / MASS)
AMPLITUDE = 5e-6


def measures(graph: Graph) -> dict[str, float]:
    return {name: float(measure.value) for name, measure in simulate(graph, engine="compiled").measures.items()}


@pytest.mark.parametrize("volts", [0.0, 3.0, GAP * math.sqrt((SENSE - DRIVE) / (2.0 * C_SENSE)), 7.0])
def test_amplitudes_at_one_degree_per_second(volts: float) -> None:
    """Coriolis force 2 m W v on a spring softened by 2 C0 V^2 / d^2; dC = 2 C0 y / d, far from the plates."""
    found = measures(library("gyroscope_capacitances.toml").with_parameters({"tuning": volts}))
    spring = SENSE - 2.0 * C_SENSE * volts**2 / GAP**2
    force = 2.0 * MASS * math.radians(1.0) * OMEGA * AMPLITUDE
    moved = force / abs(complex(spring - MASS * OMEGA**2, DAMPING * OMEGA))
    assert found["drive_amplitude"] == pytest.approx(AMPLITUDE, rel=2e-5)
    assert found["sense_amplitude"] == pytest.approx(moved, rel=1e-4)
    assert found["capacitance_amplitude"] == pytest.approx(2.0 * C_SENSE * moved / GAP, rel=1e-4)
    assert found["reciprocal_force"] == pytest.approx(2.0 * MASS * math.radians(1.0) * OMEGA * moved, rel=1e-4)


def test_the_default_voltage_tunes_the_modes() -> None:
    """As the graph of the rate response, whose sense mode is given the stiffness of the drive."""
    graph = library("gyroscope_capacitances.toml")
    at, below, above = (
        measures(graph.with_parameters({"tuning": volts}) if volts else graph)["sense_amplitude"]
        for volts in (0.0, 5.4, 6.1)
    )
    assert at > 1.05 * max(below, above)
    assert at == pytest.approx(149.0e-12, rel=1e-3)
