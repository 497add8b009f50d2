"""Groups that are linear but for products with held signals: exact steps, whose matrices follow the factors."""

import math
from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest

from proofmass.blocks import (
    Constant,
    CoriolisForce,
    Gain,
    LowPass,
    MassSpringDamper,
    PiecewiseConstant,
    Product,
    Sine,
    Sum,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph
from proofmass.runner.continuous.linearity import factors_of
from proofmass.runner.planning.plan import plan, varied
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import simulate
from tests.by_hand.lanes_alone import assert_lanes_are_runs

ENGINES: list[EngineName] = ["python", "compiled"]
MASS = 50e-9
DRIVE, SENSE = {"stiffness": 126.5, "damping": 3.14e-7}, {"stiffness": 126.7, "damping": 5.034e-7}
RATE = PiecewiseConstant(times=(0.0, 2e-4, 3e-4), values=(0.0, 20.0, -35.0), unit="rad/s")


def gyroscope(*, gains: bool = False, rotation: Block = RATE, **integration: Any) -> Graph:
    """Two modes coupled by rotation: by CoriolisForce, or by gains that a wire drives."""
    blocks: dict[str, Block] = {
        "rotation": rotation,
        "push": Sine(amplitude=1e-6, frequency=7990.0, unit="N"),
        "drive": MassSpringDamper(mass=MASS, **DRIVE),
        "sense": MassSpringDamper(mass=MASS, **SENSE),
        "on_drive": Sum(unit="N"),
    }
    wires = [
        "push.output -> on_drive.first",
        "back.OUT -> on_drive.second",
        "on_drive.output -> drive.force",
        "forth.OUT -> sense.force",
        "drive.velocity -> forth.IN",
        "sense.velocity -> back.IN",
    ]
    for name, sign in (("back", 1.0), ("forth", -1.0)):
        if gains:
            blocks[name] = Gain(input_unit="m/s", output_unit="N")
            blocks[f"{name}_rate"] = Gain(gain=sign * 2.0 * MASS, input_unit="rad/s", output_unit="kg/s")
            wires += [f"rotation.output -> {name}_rate.input", f"{name}_rate.output -> {name}.gain"]
        else:
            blocks[name] = CoriolisForce(mass=MASS, positive=sign > 0.0)
            wires += [f"rotation.output -> {name}.rotation"]
    put = {"IN": "input", "OUT": "output"} if gains else {"IN": "velocity", "OUT": "force"}
    wires = [wire.replace(".IN", f".{put['IN']}").replace(".OUT", f".{put['OUT']}") for wire in wires]
    return Graph(
        name="gyroscope",
        rate="200 kHz",
        blocks=blocks,
        wires=wires,
        probes=["drive.displacement", "sense.displacement"],
        integration=integration,
    )


def difference(one: Result, other: Result) -> float:
    return max(float(np.abs(one[s].values - other[s].values).max() / np.abs(other[s].values).max()) for s in one)


def test_a_group_with_a_coriolis_force_of_a_held_rotation_is_exact() -> None:
    solver = plan(gyroscope()).solvers[0]
    assert (solver.method, solver.factors) == ("exact", (("rotation", "output"),))
    assert plan(gyroscope(sources="continuous")).solvers[0].method == "dormand_prince"


@pytest.mark.exhaustive
def test_it_is_the_group_of_driven_gains_and_the_limit_of_small_steps() -> None:
    found = simulate(gyroscope(), samples=120, engine="python")
    assert difference(found, simulate(gyroscope(gains=True), samples=120, engine="python")) < 1e-13
    fine = simulate(gyroscope(method="dormand_prince", accuracy=1e-13), samples=120, engine="python")
    assert difference(found, fine) < 1e-11


def test_it_has_the_same_bits_in_both_engines() -> None:
    python, compiled = (simulate(gyroscope(), samples=120, engine=engine) for engine in ENGINES)
    for signal in python:
        assert python[signal].values.tobytes() == compiled[signal].values.tobytes()


def test_a_factor_that_acts_by_itself_too_against_mpmath() -> None:
    """x' = w (-k x + k w): a filter whose input and whose corner are the same held signal."""
    levels = (3.0, -0.5, 0.0, 2.0)
    graph = Graph(
        name="both",
        rate="1 kHz",
        blocks={
            "w": PiecewiseConstant(times=(0.0, 1e-3, 2e-3, 3e-3), values=levels),
            "square": Product(),
            "damped": Product(),
            "turned": Gain(gain=-1.0),
            "total": Sum(),
            "lag": LowPass(corner_frequency=100.0),
        },
        wires=[
            "w.output -> square.first",
            "w.output -> square.second",
            "w.output -> damped.first",
            "lag.output -> damped.second",
            "damped.output -> turned.input",
            "square.output -> total.first",
            "turned.output -> total.second",
            "total.output -> lag.input",
        ],
        probes=["lag.output"],
    )
    assert plan(graph).solvers[0].method == "exact"
    trace = simulate(graph, samples=5, engine="python")["lag.output"]
    x, corner, period = mpmath.mpf(0), mpmath.mpf(2 * math.pi * 100.0), mpmath.mpf("1e-3")
    for level, value in zip((*levels, 0.0), trace.values, strict=True):
        assert abs(value - x) < 1e-14 * max(1, abs(x))
        rest = mpmath.mpf(level) ** 2 / (1 + level)  # of x' = corner (w^2 - w x - x)
        x = rest + (x - rest) * mpmath.exp(-corner * (1 + level) * period)


def test_a_factor_that_stands_still_costs_one_exponential(monkeypatch: pytest.MonkeyPatch) -> None:
    from proofmass.runner.reference import advance

    made = []
    whole = advance.assemble
    monkeypatch.setattr(advance, "assemble", lambda *given: made.append(1) or whole(*given))
    simulate(gyroscope(rotation=Constant(value=1.0, unit="rad/s")), samples=60, engine="python")
    assert len(made) == 1


def test_what_a_factor_may_be() -> None:
    def rates(point: Any) -> list[float]:
        x, y, u, w = point
        return [-x + w * y + u, w * w * x - y + 3.0 * w]

    assert factors_of(rates, 4, (2, 3)) == (3,)
    assert factors_of(rates, 4, (2,)) is None
    assert factors_of(lambda p: [p[0] + p[1]], 2, (1,)) == ()
    assert factors_of(lambda p: [p[0] * p[0] * p[1]], 2, (1,)) is None
    assert factors_of(lambda p: [abs(p[0]) * p[1]], 2, (1,)) is None
    assert factors_of(lambda p: [p[0] + 1.0], 2, (1,)) == ()
    assert factors_of(lambda p: [p[0] / p[1]], 2, (1,)) is None


def test_lanes_have_the_bits_of_each_run_alone() -> None:
    masses = [MASS * (1.0 + 0.01 * number) for number in range(4)]
    planned = plan(replace(gyroscope(), probes=()))
    given = {("drive", "mass"): np.array(masses)}
    plans = [varied(planned, {"drive": MassSpringDamper(mass=mass, **DRIVE)}) for mass in masses]
    assert_lanes_are_runs(planned, given, plans, "sense")
