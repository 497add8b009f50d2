"""What people read of a tuning, line by line, from results that were written by hand."""

from dataclasses import replace

import pytest

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.quantities import LoopFigure, MeasureOf
from proofmass.graphs.tuning.build import tuning_of
from proofmass.graphs.tuning.tuning import Goal
from proofmass.runner.design.tune.text import tuned_text
from proofmass.runner.design.tune.tune import Tuned, TunedGoal
from tests.by_hand.design_texts import INTEGRATING

GAIN, NOISE = "controller.gain", "hiss.density"
FREE = {GAIN: {"at_least": 1, "at_most": 1000}, NOISE: {"at_least": 0, "at_most": 0.002}}
PHASE = {"loop": "main", "figure": "phase_margin", "at_least": "60 deg"}
HARD = Goal(LoopFigure("main", "phase_margin", "deg"), at_least=60.0)
SOFT = Goal(MeasureOf("end", "1"), at_most=2.0, soft=True)
FAST = Goal(LoopFigure("main", "bandwidth", "Hz"), maximise=True)


def tuned(*goals: TunedGoal, **more: object) -> Tuned:
    tuning = tuning_of(read_graph_text(INTEGRATING), free=FREE, goals={"phase": PHASE})
    parameters = {"before": {GAIN: 100.0, NOISE: 1e-3}, "parameters": {GAIN: 347.25, NOISE: 2e-4}}
    facts = {"at_bounds": {}, "evaluations": 1, "interrupted": False, "objective": 0.0}
    return Tuned(tuning, **{**parameters, "goals": goals, **facts, **more})  # type: ignore[arg-type]


PHASE_MET = TunedGoal("phase", HARD, 80.0, 60.0, "corner 2", 0.0125)
SHORT = TunedGoal("end", SOFT, 1.0, 2.5, "", 0.0)
PLAIN = TunedGoal("fast", FAST, 20.0, 55.0, "", 0.0)


def test_every_line_of_a_tuning_that_met_its_goals() -> None:
    assert tuned_text(tuned(PHASE_MET, SHORT, PLAIN, at_bounds={GAIN: "upper"})).splitlines() == [
        "the goals are met; 1 point tried",
        "",
        "parameter        before   after  bounds      unit",
        "controller.gain     100  347.25  1 to 1000",
        "hiss.density      0.001  0.0002  0 to 0.002  1/sqrt(Hz)",
        "",
        "goal   wanted               before   after",
        "phase  at least 60 deg          80  60 deg  binds, worst at corner 2",
        "end    at most 2 (soft)          1     2.5  short of it",
        "fast   as high as possible      20   55 Hz",
        "",
        "phase binds: relaxing its limit by 1 % gains about 1.2 %",
        "controller.gain is at its upper bound, which binds",
    ]


@pytest.mark.parametrize(("number", "words"), [(1, "the goals are met"), (2, "all 2 hard goals met")])
def test_hard_goals_are_counted(number: int, words: str) -> None:
    text = tuned_text(tuned(*[PHASE_MET] * number, SHORT, evaluations=1200, interrupted=True))
    assert text.splitlines()[0] == f"{words}; 1,200 points tried, interrupted: the best so far"


def test_goals_that_are_missed() -> None:
    """The dearest one first; what it may reach stands with its unit, and what cannot be told is left out."""
    missed = replace(PHASE_MET, after=50.0, case="", price=0.5, reachable=58.0)
    other = TunedGoal("end", replace(SOFT, soft=False), None, float("inf"), "", 0.75, reachable=float("inf"))
    silent = replace(missed, name="again", price=0.25, reachable=None)
    lines = tuned_text(tuned(missed, other, silent, SHORT)).splitlines()
    words = "no parameters within the bounds were found that meet all hard goals; missed: phase, end, again"
    assert lines[0] == f"{words}; 1 point tried"
    assert [line.split()[-2:] for line in lines[7:10]] == [["missed,", "binds"]] * 3
    assert lines[8].split()[-5:-2] == ["undefined", "no", "limit"]
    assert lines[-3:] == [
        "end is in conflict; with all other hard goals met it reaches no limit",
        "phase is in conflict; with all other hard goals met it reaches 58 deg",
        "again is in conflict",
    ]


def test_goals_without_a_value() -> None:
    text = tuned_text(tuned(PHASE_MET, replace(SHORT, after=None, why="the run has no value of end")))
    assert "end has no value: the run has no value of end" in text
    words = "no parameters that give every goal a value were found; without: end; 1 point tried"
    assert text.splitlines()[0] == words
    assert "undefined" in text
