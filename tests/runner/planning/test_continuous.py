"""Continuous blocks between the ticks: groups stepped exactly, against matrices and closed forms by hand."""

import dataclasses
import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.linalg import expm

from proofmass.blocks import Constant, LowPass, MassSpringDamper, Sine, Step, TransferFunction
from proofmass.blocks.declaration.declare import Block, Input
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.integration import Integration
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.simulate import simulate

ENGINES: list[EngineName] = ["python", "compiled"]
Array = np.ndarray[Any, np.dtype[np.float64]]


def stepped(a: Array, b: Array, period: float, inputs: Array) -> Array:
    """States at every tick, from rest, for inputs that are held over each tick."""
    n, m = b.shape
    moved = expm(np.block([[a, b], [np.zeros((m, n + m))]]) * period)
    x = np.zeros(n)
    rows = []
    for u in inputs:
        rows.append(x)
        x = moved[:n, :n] @ x + moved[:n, n:] @ u
    return np.array(rows)


class TestTwoBlocksThatDriveEachOther:
    """A mass whose velocity passes a low-pass and comes back as a force: a third-order system."""

    GAIN, CORNER = -2.0e-3, 800.0

    def graph(self, rate: str) -> Graph:
        return Graph(
            name="coupled",
            rate=rate,
            blocks={
                "shaker": Sine(amplitude=1e-6, frequency=700.0, phase=0.3, unit="N"),
                "source": Coil(),
                "mass": MassSpringDamper(damping=1e-4),
                "filter": LowPass(corner_frequency=self.CORNER, gain=self.GAIN, input_unit="m/s", output_unit="N"),
            },
            wires=[
                "shaker.output -> source.held",
                "filter.output -> source.back",
                "source.force -> mass.force",
                "mass.velocity -> filter.input",
            ],
            probes=["mass.displacement", "mass.velocity", "filter.output", "shaker.output"],
        )

    @pytest.mark.parametrize("engine", ENGINES)
    @pytest.mark.parametrize("rate", ["5 kHz", "40 kHz"])
    def test_against_the_assembled_matrices(self, engine: EngineName, rate: str) -> None:
        graph = self.graph(rate)
        result = simulate(graph, samples=600, engine=engine)
        m, c, k = 50.43e-9, 1e-4, 49.5627
        corner, fast = 2 * math.pi * self.CORNER, 2 * math.pi * 5e4
        # states: displacement, velocity, filter, coil
        a = np.array(
            [
                [0.0, 1.0, 0.0, 0.0],
                [-k / m, -c / m, 0.0, 1.0 / m],
                [0.0, corner * self.GAIN, -corner, 0.0],
                [0.0, 0.0, fast, -fast],
            ]
        )
        b = np.array([[0.0], [0.0], [0.0], [fast]])
        assert graph.rate is not None
        expected = stepped(a, b, float(1 / graph.rate), result["shaker.output"].values[:, None])
        for signal, column in (("mass.displacement", 0), ("mass.velocity", 1), ("filter.output", 2)):
            size = np.abs(expected[:, column]).max()
            assert np.abs(result[signal].values - expected[:, column]).max() < 1e-11 * size
        # one block after the other, with what the other held, is far from it
        assert [solver.group.blocks for solver in plan(graph).solvers] == [("filter", "mass", "source")]


class CoilState(NamedTuple):
    current: float


class Coil(Block):
    """Sum of two inputs through a lag of 50 kHz."""

    held = Input("N", "From outside of the group.")
    back = Input("N", "From inside of the group.")


@Coil.output("N")
def force(p: Any, x: CoilState) -> float:
    """Force."""
    return x.current


@Coil.derivative(linear=True)
def coil_derivative(p: Any, x: CoilState, held: float, back: float) -> CoilState:
    return CoilState(2.0 * math.pi * 5.0e4 * (held + back - x.current))


@pytest.mark.parametrize("engine", ENGINES)
def test_a_chain_with_feedthrough_inside_the_group(engine: EngineName) -> None:
    # (s + 3) / (s + 20) reaches the low-pass at once; then 7 / (s + 2)
    graph = Graph(
        name="chain",
        rate="50 Hz",
        blocks={
            "source": Sine(amplitude=1.0, frequency=1.7, offset=0.4),
            "lead": TransferFunction(numerator=(1.0, 3.0), denominator=(1.0, 20.0)),
            "lag": TransferFunction(numerator=(7.0,), denominator=(1.0, 2.0)),
        },
        wires=["source.output -> lead.input", "lead.output -> lag.input"],
        probes=["lead.output", "lag.output", "source.output"],
    )
    result = simulate(graph, samples=400, engine=engine)
    inputs = result["source.output"].values[:, None]
    # lead: x' = -20 x + u, y = -17 x + u; lag: z' = -2 z + 7 y
    a = np.array([[-20.0, 0.0], [7.0 * -17.0, -2.0]])
    b = np.array([[1.0], [7.0]])
    expected = stepped(a, b, 1 / 50, inputs)
    assert result["lag.output"].values == pytest.approx(expected[:, 1], rel=1e-12, abs=1e-13)
    assert result["lead.output"].values == pytest.approx(-17.0 * expected[:, 0] + inputs[:, 0], rel=1e-12, abs=1e-13)
    assert len(plan(graph).solvers) == 1


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("damping", [1e-4, 3.161935e-3, 9e-3], ids=["under", "critical", "over"])
def test_step_response_in_the_three_damping_regimes(engine: EngineName, damping: float) -> None:
    m, k, size = 50.43e-9, 49.5627, 2e-6
    critical = 2.0 * math.sqrt(m * k)
    c = critical if damping == 3.161935e-3 else damping
    graph = Graph(
        name="step",
        rate="100 kHz",
        blocks={"force": Step(amplitude=size, unit="N"), "mass": MassSpringDamper(mass=m, damping=c, stiffness=k)},
        wires=["force.output -> mass.force"],
        probes=["mass.displacement"],
    )
    trace = simulate(graph, samples=400, engine=engine)["mass.displacement"]
    t, decay, omega = trace.times, c / (2.0 * m), math.sqrt(k / m)
    if c == critical:
        left = (1.0 + omega * t) * np.exp(-omega * t)
    elif c < critical:
        damped = math.sqrt(omega**2 - decay**2)
        left = np.exp(-decay * t) * (np.cos(damped * t) + decay / damped * np.sin(damped * t))
    else:
        root = math.sqrt(decay**2 - omega**2)
        slow, fast = decay - root, decay + root
        left = (fast * np.exp(-slow * t) - slow * np.exp(-fast * t)) / (fast - slow)
    assert np.abs(trace.values - size / k * (1.0 - left)).max() < 1e-11 * size / k


@pytest.mark.parametrize("engine", ENGINES)
def test_a_constant_force_ends_in_force_over_stiffness(engine: EngineName) -> None:
    graph = Graph(
        name="rest",
        rate="1 kHz",
        blocks={"force": Constant(value=3e-6, unit="N"), "mass": MassSpringDamper(stiffness=20.0)},
        wires=["force.output -> mass.force"],
        probes=["mass.displacement", "mass.velocity"],
    )
    result = simulate(graph, samples=200, engine=engine)
    assert result["mass.displacement"].values[-1] == pytest.approx(3e-6 / 20.0, rel=1e-13)
    assert abs(result["mass.velocity"].values[-1]) < 1e-18


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("damping", [0.0, 1e-4, 3.4e-3])
def test_many_small_steps_are_one_large_step(engine: EngineName, damping: float) -> None:
    def displacement(factor: int) -> Array:
        graph = Graph(
            name="semigroup",
            rate=f"{10 * factor} kHz",
            blocks={
                "force": Step(amplitude=1e-6, start_time=0.0007, unit="N"),
                "mass": MassSpringDamper(damping=damping),
            },
            wires=["force.output -> mass.force"],
            probes=[{"signal": "mass.displacement", "every": factor}],
        )
        return simulate(graph, samples=100 * factor + 1, engine=engine)["mass.displacement"].values

    once = displacement(1)
    for factor in (2, 7, 50):
        assert np.abs(displacement(factor) - once).max() < 1e-12 * np.abs(once).max() * 10


class OneState(NamedTuple):
    level: float


def wrong(rate: Any, linear: bool = True) -> Block:
    class Made(Block):
        """A block."""

        input = Input("1", "Input.", default=0.0)

    @Made.output("1")
    def output(p: Any, x: OneState) -> float:
        """State."""
        return x.level

    @Made.derivative(linear=linear)
    def derivative(p: Any, x: OneState, input: float) -> OneState:
        return OneState(rate(x.level, input))

    return Made()


@pytest.mark.parametrize(
    ("block", "method"),
    [
        (wrong(lambda x, u: u - x, linear=False), "dormand_prince"),
        (wrong(lambda x, u: u - x * x), "dormand_prince"),
        (wrong(lambda x, u: u - abs(x)), "dormand_prince"),  # it has a corner that it does not name
        (wrong(lambda x, u: x * x * u), "dormand_prince"),
    ],
    ids=["said so", "square", "absolute", "product"],
)
def test_what_is_not_linear_is_not_stepped_exactly(block: Block, method: str) -> None:
    blocks = {"block": block, "source": Constant(value=1.0)}
    wires, probes = ["source.output -> block.input"], ["block.output"]
    graph = Graph(name="wrong", rate="1 kHz", blocks=blocks, wires=wires, probes=probes)
    assert plan(graph).solvers[0].method == method
    with pytest.raises(
        ModelError, match=r"blocks\.block: block: cannot be stepped exactly: .*block (is|are) not linear"
    ):
        simulate(dataclasses.replace(graph, integration=Integration(method="exact")), samples=3)


def test_what_is_linear_is_not_refused() -> None:
    graph = Graph(
        name="right", rate="1 kHz", blocks={"block": wrong(lambda x, u: 0.1 * u - x / 3.0)}, probes=["block.output"]
    )
    assert not simulate(graph, samples=3)["block.output"].values.any()
