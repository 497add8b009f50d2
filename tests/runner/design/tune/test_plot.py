"""The picture of a tuning: parameters, goals and loops stand where their numbers say."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from proofmass.graphs.model.quantities import LoopFigure, MeasureOf
from proofmass.graphs.tuning.tuning import Goal
from proofmass.runner.design.tune import plot
from proofmass.runner.design.tune.plot import _draw_goals, _draw_loop, plot_tuned
from proofmass.runner.design.tune.tune import TunedGoal
from proofmass.runner.output.pictures import BLUE, ORANGE
from tests.runner.design.tune.test_text import FAST, HARD, PHASE_MET, PLAIN, SHORT, tuned

BIAS = MeasureOf("bias", "V")


def bars(*goals: TunedGoal) -> list[tuple[str, float, bool]]:
    """Name, length and whether it is blue of each bar."""
    panel: Any = Figure().subplots()
    _draw_goals(tuned(*goals), panel)
    names = [label.get_text() for label in panel.get_yticklabels()]
    found = [(round(bar.get_width(), 9), to_hex(bar.get_facecolor()) == BLUE) for bar in panel.patches]
    assert {to_hex(bar.get_facecolor()) for bar in panel.patches} <= {BLUE, ORANGE}
    assert [bar.get_y() + 0.5 * bar.get_height() for bar in panel.patches] == pytest.approx([*range(len(names))])
    assert [line.get_xdata()[0] for line in panel.lines] == [0.0]
    return [(name, *pair) for name, pair in zip(names, found, strict=True)]


def limited(after: float, **limits: float) -> TunedGoal:
    return TunedGoal("bias", Goal(BIAS, **limits), 1.0, after, "", 0.0)  # type: ignore[arg-type]


def wanted(before: float | None, after: float, **what: bool) -> TunedGoal:
    return TunedGoal("bias", Goal(BIAS, **what), before, after, "", 0.0)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("goal", "length", "blue"),
    [
        (limited(60.0, at_least=50.0), 20.0, True),
        (limited(40.0, at_least=50.0), -20.0, False),
        (limited(60.0, at_most=50.0), -20.0, False),
        (limited(50.0 * (1.0 - 1e-9), at_least=50.0), -1e-7, True),
        (limited(2.0, at_least=-1.0, at_most=2.5), 20.0, True),  # the nearer limit
        (limited(-0.75, at_least=-1.0, at_most=2.5), 25.0, True),
        (limited(0.5, at_least=0.0), 50.0, True),
        (limited(50.0, at_least=10.0), 200.0, True),
        (wanted(10.0, 15.0, maximise=True), 50.0, True),
        (wanted(10.0, 15.0, minimise=True), -50.0, False),
        (wanted(10.0, 4.0, minimise=True), 60.0, True),
    ],
)
def test_a_bar_says_how_much_better_than_its_limit_or_than_before_a_goal_is(
    goal: TunedGoal, length: float, blue: bool
) -> None:
    assert bars(goal) == [("bias", pytest.approx(length), blue)]


@pytest.mark.defect("S841", before="-10 raised to 5 was drawn as 150 % worse", after="as 150 % better")
@pytest.mark.parametrize(
    ("goal", "length", "blue"),
    [
        (wanted(-10.0, 5.0, maximise=True), 150.0, True),
        (wanted(-10.0, -12.0, minimise=True), 20.0, True),
        (wanted(-10.0, -12.0, maximise=True), -20.0, False),
    ],
)
def test_better_than_a_negative_number_is_better(goal: TunedGoal, length: float, blue: bool) -> None:
    assert bars(goal) == [("bias", pytest.approx(length), blue)]


def test_goals_without_a_number_have_no_bar_and_those_that_bind_are_named() -> None:
    lost = replace(PHASE_MET, after=None)
    nothing, unknown = wanted(0.0, 1.0, maximise=True), wanted(None, 1.0, maximise=True)
    assert [name for name, _, _ in bars(lost, nothing, unknown, PHASE_MET, SHORT)] == ["phase (binds)", "end"]


def test_parameters_stand_between_their_bounds() -> None:
    """100 of 1 to 1000 is two thirds of the way in logarithms; 0.001 of 0 to 0.002 is the half."""
    panel, goals = plot_tuned(tuned(SHORT)).axes
    (line, before, after), (_, other, last) = panel.lines[:3], panel.lines[3:]
    assert line.get_xydata().tolist() == [[0.0, 0.0], [1.0, 0.0]]
    assert before.get_xydata()[0] == pytest.approx([2.0 / 3.0, 0.0])
    assert after.get_xydata()[0] == pytest.approx([math.log10(347.25) / 3.0, 0.0])
    assert other.get_xydata()[0] == pytest.approx([0.5, 1.0])
    assert last.get_xydata()[0] == pytest.approx([0.1, 1.0])
    assert [one.get_text() for one in panel.get_yticklabels()] == ["controller.gain", "hiss.density"]
    ends = [(one.get_text(), one.xy, one.get_ha()) for one in panel.texts]
    assert [(text, xy, side) for text, xy, side in ends[:2]] == [("1", (0.0, 0), "left"), ("1000", (1.0, 0), "right")]
    assert [xy for _, xy, _ in ends[2:]] == [(0.0, 1), (1.0, 1)]
    assert [text.get_text() for text in panel.get_legend().get_texts()] == ["before", "after"]
    assert len(panel.get_xticks()) == 0
    assert goals.get_title(loc="left") == "goals"


def test_a_loop_before_and_after() -> None:
    """|L| = K T / (2 sin(w T / 2)), and its phase is -90 deg - 1.5 w T."""
    size, phase = Figure().subplots(2)
    found = tuned(PLAIN)
    _draw_loop(found, "main", size, phase)
    before, after, zero = size.lines
    for line, gain in ((before, 100.0), (after, 347.25)):
        f = np.asarray(line.get_xdata())
        wt = 2.0 * math.pi * f * 1e-3
        assert line.get_ydata() == pytest.approx(20.0 * np.log10(gain * 1e-3 / (2.0 * np.sin(wt / 2.0))), abs=1e-6)
    for line in phase.lines:
        wt = 2.0 * math.pi * np.asarray(line.get_xdata()) * 1e-3
        drawn = np.asarray(line.get_ydata()) + 90.0 + np.degrees(1.5 * wt)
        assert drawn == pytest.approx(np.full(len(wt), 360.0 * round(drawn[0] / 360.0)), abs=1e-6)
    assert zero.get_ydata()[0] == 0.0
    assert (before.get_linestyle(), after.get_linestyle()) == ("--", "-")
    assert [line.get_label() for line in (before, after)] == ["before", "after"]
    assert (size.get_xscale(), size.get_title(loc="left")) == ("log", "loop main")


def test_two_loops_are_drawn_and_the_title_says_whether_goals_are_met(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[tuple[str, Any, Any]] = []
    monkeypatch.setattr(plot, "_draw_loop", lambda tuned, loop, size, phase: drawn.append((loop, size, phase)))
    figures = [LoopFigure(loop, "phase_margin", "deg") for loop in "abac"]
    goals = [replace(PHASE_MET, goal=replace(HARD, quantity=figure)) for figure in figures]
    figure = plot_tuned(tuned(SHORT, *goals))
    assert [loop for loop, _, _ in drawn] == ["a", "b"]
    assert figure.get_suptitle() == "all hard goals are met"
    rows = [panel.get_subplotspec().rowspan.start for panel in figure.axes]
    assert rows == [0, 0, 1, 2, 3, 4]
    assert [panel.get_subplotspec().colspan.start for panel in figure.axes] == [0, 1, 0, 0, 0, 0]
    assert [panel.get_subplotspec().colspan.stop for panel in figure.axes] == [1, 2, 2, 2, 2, 2]
    for _, size, phase in drawn:
        assert size.get_shared_x_axes().joined(size, phase)
    missed = plot_tuned(tuned(replace(PHASE_MET, after=10.0), replace(PHASE_MET, goal=FAST)))
    assert missed.get_suptitle() == "hard goals are missed"
