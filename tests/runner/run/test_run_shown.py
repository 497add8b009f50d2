"""What a run says of itself: method and steps of continuous blocks, ticks that overflowed, measures without value."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from proofmass.blocks import Constant, GapClosingActuator, MassSpringDamper
from proofmass.graphs.model.build import Graph
from proofmass.runner.command_line import main
from proofmass.runner.continuous.integrate import STEPS_TOO_SHORT
from proofmass.runner.planning.plan import plan
from proofmass.runner.reference import advance
from proofmass.runner.run.simulate import RunError, simulate

GRAPH = """
name = "a mass"
rate = "1 kHz"
samples = 100
wires = ["push.output -> mass.force", "source.output -> quantiser.input", "quantiser.output -> phase.input"]
probes = ["mass.displacement"]
[measures]
wander = { signal = "mass.displacement", statistic = "allan_deviation", tau = "80 ms" }
[blocks.push]
kind = "Constant"
unit = "N"
[blocks.mass]
kind = "MassSpringDamper"
[blocks.source]
kind = "Constant"
value = 3
[blocks.quantiser]
kind = "FixedQuantiser"
rate = "100 Hz"
[blocks.phase]
kind = "FixedIntegrator"
rate = "100 Hz"
gain = 100
sum_format = "(20, 17)"
output_format = "(20, 17)"
overflow = "saturate"
"""


@pytest.fixture
def run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    def run(text: str, *words: object) -> str:
        path = tmp_path / "graph.toml"
        path.write_text(text)
        assert main(["run", str(path), *map(str, words), "--engine", "python"]) == 0
        return capsys.readouterr().out

    return run


@pytest.mark.exhaustive
def test_method_and_steps_are_on_the_screen_in_json_and_in_the_report(run: Callable[..., str], tmp_path: Path) -> None:
    assert "continuous blocks mass: exact\n" in run(GRAPH)
    stepped = GRAPH.replace("[blocks.push]", '[integration]\nmethod = "runge_kutta_4"\nsubsteps = 3\n[blocks.push]')
    assert "continuous blocks mass: runge_kutta_4, 3 steps a tick, whose error is not watched\n" in run(
        stepped, "--out", tmp_path / "out"
    )
    assert (
        json.loads(run(stepped, "--json"))["integration"]
        == "mass: runge_kutta_4, 3 steps a tick, whose error is not watched"
    )
    assert "mass: runge_kutta_4, 3 steps a tick" in (tmp_path / "out" / "report.html").read_text()
    adaptive = stepped.replace("runge_kutta_4", "dormand_prince")
    assert "continuous blocks mass: dormand_prince, steps chosen for 1e-09\n" in run(adaptive)


def test_overflows_are_counted_in_ticks_of_the_block(run: Callable[..., str]) -> None:
    assert "phase: a value did not fit its format in 9 of its 10 ticks\n" in run(GRAPH)
    assert "phase: wrapped in 1 of its 10 ticks" in run(GRAPH.replace("saturate", "wrap"), "--set", "phase.gain=20")


def test_a_run_that_is_too_short_for_a_measure_says_so(run: Callable[..., str]) -> None:
    assert "wander has no value: the run is too short for the allan_deviation of mass.displacement" in run(GRAPH)
    assert "wander = 0 m" in run(GRAPH, "--samples", 200)


def swinging(**integration: object) -> Graph:
    return Graph(
        name="oscillator",
        rate="100 kHz",
        blocks={
            "drive": Constant(value=1.0, unit="V"),
            "plates": GapClosingActuator(bias=1.0),
            "mass": MassSpringDamper(mass=1e-9, damping=2.5e-8, stiffness=15.79),
        },
        wires=[
            "drive.output -> plates.voltage",
            "mass.displacement -> plates.displacement",
            "plates.force -> mass.force",
        ],
        probes=["mass.displacement"],
        integration=integration,
    )


@pytest.mark.parametrize(
    ("accuracy", "method"), [(1e-9, "dormand_prince"), (1e-10, "dormand_prince"), (1e-13, "dormand_prince")]
)
def test_a_plain_oscillator_is_not_taken_for_stiff(accuracy: float, method: str) -> None:
    assert plan(swinging(accuracy=accuracy)).solvers[0].method == method


def test_what_is_stiff_is() -> None:
    stiff = swinging(accuracy=1e-9)
    blocks = dict(stiff.blocks) | {"mass": MassSpringDamper(mass=1e-9, damping=1.0, stiffness=15.79)}
    assert plan(Graph(**{**vars(stiff), "blocks": blocks})).solvers[0].method == "radau"


@pytest.mark.parametrize(
    ("accuracy", "hint"),
    [(1e-14, "accuracy = 1e-14 is below what rounding leaves of these numbers: ask for 1e-12"), (1e-9, "unstable")],
)
def test_steps_that_get_too_short_below_rounding_are_called_that(
    accuracy: float, hint: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(advance, "integrate", lambda *given: STEPS_TOO_SHORT)
    with pytest.raises(RunError) as told:
        simulate(swinging(method="dormand_prince", accuracy=accuracy), samples=2, engine="python")
    assert "no step is short enough for the accuracy" in told.value.problem.got
    assert hint in told.value.problem.hint
