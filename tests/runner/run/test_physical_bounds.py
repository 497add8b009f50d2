"""Where physics ends a run ends too, with the block, the port and the tick; stops before that keep it going."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from proofmass.blocks import Constant, GapClosingActuator, MassBetweenStops, MassSpringDamper, Ramp
from proofmass.graphs.model.build import Graph
from proofmass.runner.planning.plan import plan, varied
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import RunError, simulate
from proofmass.runner.targets.native_lanes import CompiledLanes, Lanes

ENGINES: list[EngineName] = ["python", "compiled"]
SUSPENSION = {"mass": 1e-9, "damping": 1e-6, "stiffness": 1.0}


def pulled(mass: MassSpringDamper | MassBetweenStops, rate: str = "1 MHz", **integration: Any) -> Graph:
    plates = GapClosingActuator(bias=0.0, capacitance=0.2e-12, gap=4e-6, push_pull=False)
    return Graph(
        name="pull-in",
        rate=rate,
        blocks={"drive": Constant(value=30.0, unit="V"), "plates": plates, "mass": mass},
        wires=[
            "drive.output -> plates.voltage",
            "mass.displacement -> plates.displacement",
            "plates.force -> mass.force",
        ],
        probes=["mass.displacement"] + (["mass.last_impact"] if isinstance(mass, MassBetweenStops) else []),
        integration=integration,
    )


@pytest.mark.exhaustive
@pytest.mark.defect("S8", before="654 um with a gap of 4 um, exit 0", after="the run ends: block, port, tick, cure")
@pytest.mark.parametrize("engine", ENGINES)
def test_a_plate_that_reaches_its_electrode_ends_the_run(engine: EngineName) -> None:
    with pytest.raises(RunError) as told:
        simulate(pulled(MassSpringDamper(**SUSPENSION)), samples=400, engine=engine)
    assert told.value.problem.key == "plates.force"
    assert told.value.problem.message == "has no value in tick 14, t = 1.4e-05 s"
    assert "give the mass stops within the gap, as MassBetweenStops has" in told.value.problem.hint


@pytest.mark.exhaustive("dormand_prince", "radau")
@pytest.mark.parametrize("method", ["runge_kutta_4", "dormand_prince", "radau"])
def test_every_method_names_the_plates(method: str) -> None:
    with pytest.raises(RunError) as told:
        simulate(pulled(MassSpringDamper(**SUSPENSION), method=method), samples=400, engine="python")
    assert told.value.problem.key == "plates.force"
    assert "in tick 14" in told.value.problem.message


def impact(rate: str, samples: int, engine: EngineName = "python", **integration: Any) -> Result:
    mass = MassBetweenStops(**SUSPENSION, lowest=-3.99e-6, highest=3.99e-6)
    return simulate(pulled(mass, rate, **integration), samples=samples, engine=engine)


@pytest.mark.exhaustive
def test_a_stop_before_the_electrode_is_found_though_a_step_would_go_beyond_both() -> None:
    fine = impact("50 MHz", 1000, method="dormand_prince", accuracy=1e-12)["mass.last_impact"].values.max()
    coarse = impact("100 kHz", 20, substeps=20)
    assert coarse["mass.last_impact"].values[-1] == pytest.approx(fine, rel=1e-3)
    assert coarse["mass.displacement"].values[-1] == 3.99e-6
    assert np.isfinite(coarse["mass.displacement"].values).all()


@pytest.mark.exhaustive
def test_steps_cut_short_before_an_electrode_have_the_same_bits_in_both_engines() -> None:
    python, compiled = (impact("100 kHz", 20, engine, substeps=20) for engine in ENGINES)
    for signal in python:
        assert python[signal].values.tobytes() == compiled[signal].values.tobytes()


def softening() -> Graph:
    """A spring whose driven stiffness falls through zero."""
    return Graph(
        name="a spring that softens",
        rate="1 kHz",
        blocks={
            "soft": Ramp(offset=49.5, slope=-1000.0, unit="N/m"),
            "push": Constant(value=1e-6, unit="N"),
            "mass": MassSpringDamper(),
        },
        wires=["push.output -> mass.force", "soft.output -> mass.stiffness"],
        probes=["mass.displacement"],
    )


@pytest.mark.defect("S8", before="a stiffness below zero, exit 0", after="the run ends: parameter, tick, bounds, cure")
@pytest.mark.parametrize("engine", ENGINES)
def test_a_driven_parameter_that_leaves_its_bounds_ends_the_run(engine: EngineName) -> None:
    assert len(simulate(softening(), samples=50, engine=engine)["mass.displacement"].values) == 50
    with pytest.raises(RunError) as told:
        simulate(softening(), samples=200, engine=engine)
    problem = told.value.problem
    assert (problem.key, problem.message) == ("mass.stiffness", "leaves its bounds in tick 50, t = 0.05 s")
    assert (problem.got, problem.expected) == ("-0.5 N/m", "a number > 0, in N/m")
    assert "limit what drives it, soft.output" in problem.hint


@pytest.mark.exhaustive
def test_in_lanes_only_the_runs_that_leave_the_bounds_are_unsound() -> None:
    planned = plan(replace(softening(), probes=()))
    slopes = [-1000.0, -100.0, -1000.0, -10.0]
    given = {("soft", "slope"): np.array(slopes)}
    plans = [varied(planned, {"soft": Ramp(offset=49.5, slope=slope, unit="N/m")}) for slope in slopes]
    lanes = Lanes(CompiledLanes(planned, set(given), 4), 7, range(4), given, plans)
    lanes.advance(200)
    assert list(lanes.sound()) == [False, True, False, True]
