"""Non-linear continuous groups against closed forms and scipy.integrate, in both engines; orders of convergence."""

import dataclasses
import itertools
import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from proofmass.blocks import Constant, Gain, LowPass, MassSpringDamper, Product, Saturation, Sine, Sum, UnitDelay
from proofmass.blocks.declaration.declare import Block, Input, param
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import RunError, simulate

ENGINES: list[EngineName] = ["python", "compiled"]
METHODS = ["runge_kutta_4", "dormand_prince", "radau"]


class Angle(NamedTuple):
    angle: float
    velocity: float


class Pendulum(Block):
    """A pendulum of large angle, in units of its own frequency."""

    damping: float = param("1/s", "Damping.", default=0.0)

    torque = Input("1/s^2", "Torque.", default=0.0)


@Pendulum.output("rad")
def angle(p: Any, x: Angle) -> float:
    """Angle."""
    return x.angle


@Pendulum.start
def start(p: Any) -> Angle:
    return Angle(1.0, 0.0)


@Pendulum.derivative(linear=False)
def swing(p: Any, x: Angle, torque: float) -> Angle:
    cubed = x.angle * x.angle * x.angle
    return Angle(x.velocity, torque - p.damping * x.velocity - (x.angle - cubed / 6.0))


def pendulum(rate: str = "10 Hz", **integration: Any) -> Graph:
    return Graph(name="pendulum", rate=rate, blocks={"it": Pendulum()}, probes=["it.angle"], integration=integration)


def reference(times: Any) -> Any:
    """The pendulum's angle by an independent integrator."""
    rates = lambda t, x: [x[1], -(x[0] - x[0] ** 3 / 6.0)]  # noqa: E731
    return solve_ivp(rates, (0, times[-1]), [1.0, 0.0], method="DOP853", rtol=1e-13, atol=1e-14, t_eval=times).y[0]


def same_bits(python: Result, compiled: Result) -> None:
    for signal in python:
        rows = len(python[signal].values)
        assert python[signal].values.tobytes() == compiled[signal].values[:rows].tobytes(), signal


@pytest.mark.exhaustive("radau", "dormand_prince")
@pytest.mark.parametrize("method", METHODS)
def test_accuracy_of_a_swing_of_large_angle(method: str) -> None:
    graph = pendulum(method=method, accuracy=1e-11)
    trace = simulate(graph, samples=301, engine="compiled")["it.angle"]
    assert np.abs(trace.values - reference(trace.times)).max() < 2e-9
    same_bits(simulate(graph, samples=20, engine="python"), simulate(graph, samples=20, engine="compiled"))


@pytest.mark.parametrize(("method", "order"), [("runge_kutta_4", 4), ("dormand_prince", 5)])
def test_order_of_convergence(method: str, order: int) -> None:
    errors = []
    for number in (8, 16, 32):
        if method == "runge_kutta_4":
            graph = pendulum("1 Hz", method=method, substeps=number)
        else:  # a tolerance so loose that every step is accepted as it is: one in each tick
            graph = pendulum(f"{number} Hz", method=method, accuracy=0.1, substeps=1)
        trace = simulate(graph, duration="20 s", engine="compiled")["it.angle"]
        errors.append(np.abs(trace.values - reference(trace.times)).max())
    slopes = np.diff(np.log2(errors))
    assert -order - 0.35 < slopes.min() <= slopes.max() < -order + 0.35, slopes


def test_a_radau_step_has_order_five() -> None:
    from proofmass.runner.continuous.radau import radau_step, scratch

    def rates(context: None, time: float, x: list[float], out: list[float]) -> None:
        out[0] = -x[0] * x[0] * math.cos(time)

    errors = []
    for steps in (10, 20, 40):
        x, h = [1.0], 2.0 / steps
        work = tuple([0.0] * length for length in scratch(1))
        for step in range(steps):
            moved, error = [0.0], [0.0]
            radau_step(rates, None, step * h, h, x, moved, error, [1.0], work)
            x = moved
        errors.append(abs(x[0] - 1.0 / (1.0 + math.sin(2.0))))
    assert np.diff(np.log2(errors)).max() < -4.6


class VanDerPol(Block):
    """Van der Pol's oscillator, stiff."""

    stiffness: float = param("1", "Ratio of its time scales.", default=1000.0)


@VanDerPol.output("1")
def level(p: Any, x: Angle) -> float:
    """First state."""
    return x.angle


@VanDerPol.start
def begin(p: Any) -> Angle:
    return Angle(2.0, 0.0)


@VanDerPol.derivative(linear=False)
def relax(p: Any, x: Angle) -> Angle:
    return Angle(x.velocity, p.stiffness * (1.0 - x.angle * x.angle) * x.velocity - x.angle)


@pytest.mark.exhaustive
def test_what_is_stiff_is_stepped_implicitly() -> None:
    graph = Graph(name="stiff", rate="0.1 Hz", blocks={"it": VanDerPol()}, probes=["it.level"])
    solver = plan(graph).solvers[0]
    assert solver.method == "radau"
    trace = simulate(graph, samples=201, engine="compiled")["it.level"]
    rates = lambda t, x: [x[1], 1000.0 * (1.0 - x[0] ** 2) * x[1] - x[0]]  # noqa: E731
    expected = solve_ivp(rates, (0, 2000), [2.0, 0.0], method="Radau", rtol=1e-9, atol=1e-11, t_eval=trace.times).y[0]
    assert np.abs(trace.values - expected).max() < 1e-6
    same_bits(simulate(graph, samples=6, engine="python"), simulate(graph, samples=6, engine="compiled"))


def test_sub_steps_follow_from_the_accuracy() -> None:
    assert plan(pendulum("1 Hz", accuracy=1e-9)).solvers[0].method == "dormand_prince"
    counts = [
        plan(pendulum("0.1 Hz", accuracy=a, method="runge_kutta_4")).solvers[0].substeps for a in (1e-4, 1e-8, 1e-12)
    ]
    assert counts[1] == pytest.approx(10 * counts[0], rel=0.05)
    assert counts[2] == pytest.approx(10 * counts[1], rel=0.02)
    assert plan(pendulum("1 Hz", substeps=3)).solvers[0].substeps == 3


def test_a_sine_is_stepped_like_a_time_constant_of_its_frequency() -> None:
    says = {"method": "runge_kutta_4", "sources": "continuous"}
    counts = []
    for sine, corner in ((1.0, 1e3), (1e3, 1.0)):
        blocks = {"sine": Sine(frequency=sine), "filter": LowPass(corner_frequency=corner)}
        wires = ["sine.output -> filter.input"]
        graph = Graph(name="sine", rate="1 kHz", blocks=blocks, wires=wires, integration=says)
        counts.append(plan(graph).solvers[0].substeps)
    assert counts[0] == counts[1] > 10


def test_a_tick_of_very_many_time_constants_is_for_an_implicit_method() -> None:
    assert plan(pendulum("1 uHz", method="radau")).solvers[0].method == "radau"
    for method in ("runge_kutta_4", "dormand_prince"):
        with pytest.raises(ModelError, match=r"needs \S+ sub-steps in each tick(.|\n)*radau"):
            plan(pendulum("1 uHz", method=method))


def spring(*between: str, **more: Any) -> Graph:
    """A mass whose displacement acts back on it through blocks in a chain: with the force of a spring of 30 N/m."""
    blocks: dict[str, Block] = {
        "push": Sine(amplitude=1e-6, frequency=700.0, unit="N"),
        "mass": MassSpringDamper(),
        "total": Sum(unit="N"),
        "spring": Gain(gain=-30.0, input_unit="m", output_unit="N"),
    }
    chain = {"limit": Saturation(lowest=-1.0, highest=1.0, unit="N"), "late": UnitDelay(unit="N")}
    names = ["spring", *between, "total"]
    wires = ["push.output -> total.first", "total.output -> mass.force", "mass.displacement -> spring.input"]
    wires += [f"{a}.output -> {b}.{'second' if b == 'total' else 'input'}" for a, b in itertools.pairwise(names)]
    return Graph(
        name="spring",
        rate="50 kHz",
        blocks=blocks | {name: chain[name] for name in between},
        wires=wires,
        probes=["mass.displacement"],
        **more,
    )


def test_a_gain_between_continuous_blocks_acts_at_every_instant() -> None:
    plain = spring()
    stiffer = plain.with_parameters({"spring.gain": 0.0, "mass.stiffness": 49.5627 + 30.0})
    found, expected = (
        simulate(g, samples=3000, engine="compiled")["mass.displacement"].values for g in (plain, stiffer)
    )
    assert plan(plain).solvers[0].exact
    assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()
    # One that samples, because it has a state or a rate of its own, is late by up to a tick.
    for sampled in (spring("late"), dataclasses.replace(plain, rates={"spring": "50 kHz"})):
        assert "spring" not in plan(sampled).solvers[0].group.members
        late = simulate(sampled, samples=3000, engine="compiled")["mass.displacement"].values
        assert np.abs(late - expected).max() > 1e-3 * np.abs(expected).max()


@pytest.mark.exhaustive
def test_a_limit_far_away_is_not_linear_all_the_same() -> None:
    limited, plain = spring("limit"), spring()
    assert plan(limited).solvers[0].method == "dormand_prince"
    found, expected = (
        simulate(g, samples=500, engine="compiled")["mass.displacement"].values for g in (limited, plain)
    )
    assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()
    same_bits(simulate(limited, samples=60, engine="python"), simulate(limited, samples=60, engine="compiled"))


class TestFirstOrderHold:
    """An input that moves on straight lines between ticks."""

    @pytest.mark.exhaustive("runge_kutta_4")
    @pytest.mark.parametrize("method", ["exact", "runge_kutta_4"])
    def test_against_an_independent_integration(self, method: str) -> None:
        integration = {"sources": "first_order_hold", "method": method, "accuracy": 1e-12}
        graph = spring(integration=integration)
        result = simulate(graph, samples=200, engine="compiled")
        same_bits(simulate(graph, samples=30, engine="python"), result)
        rate, force = 50e3, lambda n: 1e-6 * math.sin(2 * math.pi * 700.0 * n / 50e3)
        x = np.zeros(2)
        m, c, k = 50.43e-9, 3.4e-3, 79.5627
        for tick in range(199):
            assert abs(result["mass.displacement"].values[tick] - x[0]) < 1e-10 * 2e-8
            u0, u1 = force(tick), force(tick + 1)
            rates = lambda t, x, u0=u0, u1=u1: [x[1], (u0 + (u1 - u0) * t * rate - c * x[1] - k * x[0]) / m]  # noqa: E731
            x = solve_ivp(rates, (0, 1 / rate), x, method="DOP853", rtol=1e-13, atol=[1e-24, 1e-19]).y[:, -1]

    def test_a_ramp_is_followed_exactly(self) -> None:
        from proofmass.blocks import Ramp

        graph = spring(integration={"sources": "first_order_hold"})
        graph = dataclasses.replace(graph, blocks={**graph.blocks, "push": Ramp(slope=1e-3, unit="N")})
        trace = simulate(graph, samples=2000, engine="compiled")["mass.displacement"]
        late = 3.4e-3 / 79.5627
        assert trace.values[-500:] == pytest.approx(1e-3 * (trace.times[-500:] - late) / 79.5627, rel=1e-10)


def test_sources_at_every_instant() -> None:
    graph = spring(integration={"sources": "continuous", "method": "runge_kutta_4", "accuracy": 1e-11})
    assert ("push", "output") in plan(graph).solvers[0].group.nodes
    trace = simulate(graph, samples=20_000, engine="compiled")["mass.displacement"]
    w, m, c, k = 2 * math.pi * 700.0, 50.43e-9, 3.4e-3, 79.5627
    gain = 1e-6 / (k - m * w * w + 1j * w * c)
    expected = (gain * np.exp(1j * w * trace.times)).imag
    assert np.abs(trace.values - expected)[-5000:].max() < 1e-8 * abs(gain)


@pytest.mark.exhaustive
def test_a_parameter_driven_within_the_group() -> None:
    # k(x) = 50 N/m (1 + (x / 1 um)^2): the stiffness follows the displacement at every instant
    graph = Graph(
        name="hardening",
        rate="100 kHz",
        blocks={
            "push": Sine(amplitude=3e-5, frequency=900.0, unit="N"),
            "mass": MassSpringDamper(),
            "square": Product(first_unit="m", second_unit="m"),
            "harder": Gain(gain=50.0e12, input_unit="m^2", output_unit="N/m"),
            "rest": Constant(value=50.0, unit="N/m"),
            "total": Sum(unit="N/m"),
        },
        wires=[
            "push.output -> mass.force",
            "mass.displacement -> square.first",
            "mass.displacement -> square.second",
            "square.output -> harder.input",
            "harder.output -> total.first",
            "rest.output -> total.second",
            "total.output -> mass.stiffness",
        ],
        probes=["mass.displacement"],
        integration={"sources": "continuous", "method": "runge_kutta_4", "accuracy": 1e-11},
    )
    trace = simulate(graph, samples=400, engine="compiled")["mass.displacement"]
    same_bits(simulate(graph, samples=40, engine="python"), simulate(graph, samples=40, engine="compiled"))
    w, m, c = 2 * math.pi * 900.0, 50.43e-9, 3.4e-3
    rates = lambda t, x: [  # noqa: E731
        x[1],
        (3e-5 * math.sin(w * t) - c * x[1] - 50.0 * (1.0 + (x[0] * 1e6) ** 2) * x[0]) / m,
    ]
    times = trace.times
    expected = solve_ivp(rates, (0, times[-1]), [0, 0], method="DOP853", rtol=1e-12, atol=[1e-20, 1e-15], t_eval=times)
    assert np.abs(trace.values - expected.y[0]).max() < 1e-8 * np.abs(trace.values).max()


class Explosion(NamedTuple):
    size: float


class Explosive(Block):
    """x' = x^2: infinite after one second."""


@Explosive.output("1")
def size(p: Any, x: Explosion) -> float:
    """State."""
    return x.size


@Explosive.start
def lit(p: Any) -> Explosion:
    return Explosion(1.0)


@Explosive.derivative(linear=False)
def explode(p: Any, x: Explosion) -> Explosion:
    return Explosion(x.size * x.size)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_solution_that_ends_is_named(engine: EngineName) -> None:
    graph = Graph(
        name="explosion",
        rate="7.5 Hz",  # it ends within a tick, not on the edge of one
        blocks={"it": Explosive()},
        probes=["it.size"],
        integration={"method": "dormand_prince"},
    )
    with pytest.raises(RunError) as told:
        simulate(graph, samples=100, engine=engine)
    assert told.value.problem.key == "it.derivative"
    assert "in tick 7, t = 0.933333333 s" in str(told.value)
    assert "no step is short enough" in str(told.value)
