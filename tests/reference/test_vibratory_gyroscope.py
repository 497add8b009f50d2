"""The two-mode gyroscope of separate blocks against SciPy's DOP853, and what coupling one tick late would do to it."""

import math

import numpy as np
import pytest
from scipy.integrate import ode, solve_ivp

from proofmass.blocks import Gain, MassSpringDamper, Step, Sum
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.simulate import simulate
from tests.by_hand.amounts import amounts

GRAPH = library_file("vibratory_gyroscope.toml")
MASS, GAP, BIAS, CAPACITANCE = 48.67e-9, 4e-6, 15.0, 0.05e-12
OMEGA, TURN = 2.0 * math.pi * 7963.0, 2.0 * math.pi * 20.0


def rates(t: float, x: list[float]) -> list[float]:
    """Equations 6 and 7, and 8 for both plates."""
    v = math.sin(OMEGA * t)
    near, far = (BIAS + v) / (1.0 - x[0] / GAP), (BIAS - v) / (1.0 + x[0] / GAP)
    force = 0.5 * CAPACITANCE / GAP * (near * near - far * far)
    coupling = 2.0 * MASS * math.pi / 3.0 * math.sin(TURN * t)
    drive = (force + coupling * x[3] - 18.9e-6 * x[1] - 122.28 * x[0]) / MASS
    return [x[1], drive, x[3], (-coupling * x[1] - 57e-6 * x[3] - 132.23 * x[2]) / MASS]


def in_nanometres(t: float, y: list[float]) -> list[float]:
    """The same in nm and nm OMEGA, since the integrator in compiled code takes one tolerance for all."""
    r = rates(t, [1e-9 * y[0], 1e-9 * OMEGA * y[1], 1e-9 * y[2], 1e-9 * OMEGA * y[3]])
    return [1e9 * r[0], 1e9 / OMEGA * r[1], 1e9 * r[2], 1e9 / OMEGA * r[3]]


@pytest.mark.parametrize("periods", amounts(250, 10_000))
def test_periods_within_a_ten_millionth(periods: int) -> None:
    graph = read_graph(GRAPH)
    assert plan(graph).solvers[0].group.blocks == ("drive", "sense")
    every = 127 * 64 + 5
    samples = int(periods / 7963.0 * 510e3)
    probed = [{"signal": s, "every": every} for s in ("drive.displacement", "sense.displacement")]
    result = simulate(Graph(**{**graph.__dict__, "probes": probed}), samples=samples, engine="compiled")
    solver = ode(in_nanometres).set_integrator("dop853", rtol=1e-12, atol=1e-14, nsteps=10**7)
    solver.set_initial_value([0.0, 0.0, 0.0, 0.0])
    times = result["drive.displacement"].times
    expected = np.array([[0.0] * 4, *(solver.integrate(float(t)) for t in times[1:])])
    assert solver.successful()
    for signal, column in (("drive.displacement", 0), ("sense.displacement", 2)):
        found, right = 1e9 * result[signal].values, expected[:, column]
        assert np.abs(found - right).max() < 1e-7 * np.abs(right).max()


def test_the_reference_is_that_of_solve_ivp() -> None:
    once = solve_ivp(rates, (0.0, 2e-3), [0.0] * 4, method="DOP853", rtol=1e-12, atol=[1e-21, 1e-16, 1e-23, 1e-18])
    result = simulate(read_graph(GRAPH), samples=1021, engine="compiled")
    for signal, row in (("drive.displacement", 0), ("sense.displacement", 2)):
        assert result[signal].values[-1] == pytest.approx(
            once.y[row, -1], rel=1e-7, abs=1e-7 * np.abs(once.y[row]).max()
        )


def damping(sampled: bool) -> float:
    """Damping of the sense mode, from its ring-down, with a spring of -1 N/m in a block of its own."""
    rate = round(64 * math.sqrt(131.23 / MASS) / (2.0 * math.pi))
    graph = Graph(
        name="softened",
        rate=rate,
        rates={"soft": rate} if sampled else {},
        blocks={
            "kick": Step(amplitude=1e-6, duration=20.0 / rate, unit="N"),
            "sense": MassSpringDamper(mass=MASS, stiffness=132.23, damping=57e-6),
            "soft": Gain(gain=1.0, input_unit="m", output_unit="N"),
            "total": Sum(unit="N"),
        },
        wires=[
            "kick.output -> total.first",
            "sense.displacement -> soft.input",
            "soft.output -> total.second",
            "total.output -> sense.force",
        ],
        probes=["sense.displacement", "sense.velocity"],
    )
    result = simulate(graph, samples=64 * 40, engine="compiled")
    x, v = (result[f"sense.{port}"].values[30:] for port in ("displacement", "velocity"))
    # d/dt of the phasor x w' + i (v + g x) is -g + i w', with g = damping / 2 m
    decay, omega = 57e-6 / (2.0 * MASS), math.sqrt(131.23 / MASS)
    size = np.log(np.hypot(math.sqrt(omega**2 - decay**2) * x, v + decay * x))
    return float(-2.0 * MASS * np.polyfit(np.arange(len(size)) / rate, size, 1)[0])


def test_effective_damping_within_a_hundredth_of_a_per_cent() -> None:
    assert damping(sampled=False) == pytest.approx(57e-6, rel=1e-4)
    late = 57e-6 + 0.5 / (64 * math.sqrt(131.23 / MASS) / (2.0 * math.pi))  # half a tick of 1 N/m
    assert damping(sampled=True) == pytest.approx(late, rel=1e-3)
    assert late > 1.01 * 57e-6
