"""Quantities with their derivatives: against closed forms, differences of whole evaluations, and python-control."""

import math

import control
import numpy as np
import pytest

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.quantities import FIGURES
from proofmass.graphs.tuning.build import tuning_of
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.design.quantities.evaluator import STABLE, Evaluator
from proofmass.runner.design.quantities.loop_figures import step_figures
from tests.by_hand.design_texts import INTEGRATING

GRAPH = read_graph_text(INTEGRATING)
GOALS = {figure: {"loop": "main", "figure": figure, "at_least": 0} for figure in FIGURES} | {
    "noise": {"noise": "plant.output", "minimise": True},
    "in band": {"noise": "plant.output", "band": [1, 50], "minimise": True},
    "referred": {"noise": "plant.output", "input": "wanted.output", "band": [1, 50], "minimise": True},
    "scale": {"scale_factor": "plant.output", "input": "wanted.output", "at_least": 0},
    "end": {"measure": "end", "at_least": 0},
}
FREE = {"controller.gain": {"at_least": 1, "at_most": 1000}, "plant.gain": {"at_least": 0.1, "at_most": 10}}


@pytest.fixture(scope="module")
def evaluator() -> Evaluator:
    tuning = tuning_of(GRAPH, free=FREE, goals=GOALS)
    widths = {name: free.at_most - free.at_least for name, free in tuning.free.items()}
    return Evaluator(GRAPH, {name: goal.quantity for name, goal in tuning.goals.items()}, "", widths)


@pytest.mark.parametrize("gain", [100.0, 350.0])
def test_margins_are_those_of_the_closed_form(evaluator: Evaluator, gain: float) -> None:
    at = evaluator.readings({"controller.gain": gain, "plant.gain": 1.0})
    turn = 2.0 * math.asin(gain * 1e-3 / 2.0)  # w T at the crossover
    phase = at["phase_margin"]
    assert phase is not None
    assert phase.value == pytest.approx(90.0 - math.degrees(1.5 * turn), rel=1e-9)
    by_gain = -math.degrees(1.5 * 1e-3 / math.sqrt(1.0 - (gain * 1e-3 / 2.0) ** 2))
    assert phase.slopes["controller.gain"] == pytest.approx(by_gain, rel=1e-9)
    assert phase.slopes["plant.gain"] == pytest.approx(by_gain * gain, rel=1e-9)
    limit = at["gain_margin"]  # L is real where 1.5 w T = 90 deg: K T = 2 sin(30 deg) = 1
    assert limit is not None
    assert limit.value == pytest.approx(-20.0 * math.log10(gain * 1e-3), rel=1e-9)
    assert limit.slopes["controller.gain"] == pytest.approx(-20.0 / math.log(10.0) / gain, rel=1e-9)
    # |T|^2 = g^2 / |z^2 - z + g|^2 is 1 / 2 where 4 g c^2 - 2 (1 + g) c + 2 - 2 g - g^2 = 0, c = cos w T, g = K T
    g, wide = 1e-3 * gain, at["bandwidth"]
    c = (1.0 + g - math.sqrt((1.0 + g) ** 2 - 4.0 * g * (2.0 - 2.0 * g - g * g))) / (4.0 * g)
    by_g = -(4.0 * c * c - 2.0 * c - 2.0 - 2.0 * g) / (8.0 * g * c - 2.0 * (1.0 + g))  # of c
    assert wide is not None
    assert wide.value == pytest.approx(math.acos(c) * 1e3 / (2.0 * math.pi), rel=1e-9)
    by_gain = -by_g / math.sqrt(1.0 - c * c) / (2.0 * math.pi)
    assert wide.slopes["controller.gain"] == pytest.approx(by_gain, rel=1e-6)


@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize(("name", "step"), [("controller.gain", 2.0), ("plant.gain", 0.02)])
def test_a_measure_moves_as_its_values_do(evaluator: Evaluator, name: str, step: float) -> None:
    values = {"controller.gain": 100.0, "plant.gain": 1.0}
    at, *sides = (evaluator.readings({**values, name: values[name] + side * step})["end"] for side in (0.0, 1.0, -1.0))
    assert at is not None
    assert [side is not None for side in sides] == [True, True]
    high, low = (side.value for side in sides if side is not None)
    assert at.slopes[name] == pytest.approx((high - low) / (2.0 * step), rel=1e-2)
    assert at.slopes[name] != 0.0


@pytest.mark.exhaustive
def test_derivatives_are_those_of_differences_between_whole_evaluations(evaluator: Evaluator) -> None:
    nominal = {"controller.gain": 300.0, "plant.gain": 1.1}
    exact = evaluator.readings(nominal)
    for name, value in nominal.items():
        step = 1e-5 * value
        sides = [evaluator.readings({**nominal, name: value + side * step}, slopes=False) for side in (1.0, -1.0)]
        for goal in (g for g in GOALS if g != "end"):
            readings = [side[goal] for side in sides]
            assert readings[0] is not None
            assert readings[1] is not None
            difference = (readings[0].value - readings[1].value) / (2.0 * step)
            found = exact[goal]
            assert found is not None
            rounding = 1e-9 * abs(found.value) / value
            assert found.slopes.get(name, 0.0) == pytest.approx(difference, rel=2e-5, abs=rounding), goal


def test_a_loop_that_is_not_stable_has_a_growth_and_beside_it_are_runs_alone(evaluator: Evaluator) -> None:
    at = evaluator.readings({"controller.gain": 1100.0, "plant.gain": 1.0})
    grown = at[f"{STABLE} main"]
    assert grown is not None
    roots = np.roots([1.0, -1.0, 1.1])  # z^2 - z + K T
    assert grown.value == pytest.approx(math.log(max(abs(roots))), rel=1e-9)
    assert grown.slopes["controller.gain"] == pytest.approx(0.5 / 1100.0, rel=1e-6)  # |z|^2 = K T
    assert [goal for goal in GOALS if at[goal] is not None] == ["end"]


def test_a_measure_is_what_a_run_gives(evaluator: Evaluator) -> None:
    end = evaluator.readings({"controller.gain": 100.0, "plant.gain": 1.0})["end"]
    assert end is not None
    assert end.value == pytest.approx(1.0, abs=0.2)


def test_step_figures_are_those_of_python_control() -> None:
    found = step_figures(margins(GRAPH.with_parameters({"controller.gain": 500.0})))
    closed = control.tf([0.5], [1.0, -1.0, 0.5], 1e-3)
    known = control.step_info(closed, T=np.arange(400) * 1e-3)
    assert found["overshoot"] == pytest.approx(known["Overshoot"], rel=1e-6)
    assert abs(found["settling_time"] - known["SettlingTime"]) <= 1e-3, "between the ticks it is interpolated"
