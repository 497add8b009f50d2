"""Worst cases: closed forms, brute force over corners and random points, ranges of tolerances and studies."""

import itertools
import math
import os
import signal
from typing import Any

import numpy as np
import pytest

from proofmass import simulate
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.quantities import MeasureOf
from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.runner.design.quantities.evaluator import Evaluator
from proofmass.runner.design.worst.box import box_of
from proofmass.runner.design.worst.plot import plot_worst
from proofmass.runner.design.worst.text import worst_text
from proofmass.runner.design.worst.worst import WorstCases, worst
from tests.by_hand.design_texts import COUPLED, INTEGRATING, RESONATOR

GRAPH = read_graph_text(INTEGRATING)
OPEN = """
name = "open"
rate = "1 kHz"
wires = ["source.output -> gain.input"]
[blocks.source]
kind = "Constant"
[blocks.gain]
kind = "Gain"
"""
FLICKER = """
name = "measures"
rate = "0.01 Hz"
samples = 11
[blocks.noise]
kind = "FlickerNoise"
lowest_frequency = 1e-4
highest_frequency = 1e-3
[blocks.rise]
kind = "Ramp"
[measures]
last = { signal = "noise.value", statistic = "last" }
end = { signal = "rise.output", statistic = "last" }
"""
PHASE = {"phase": {"loop": "main", "figure": "phase_margin"}}
COUPLED_GRAPH = read_graph_text(COUPLED)
EIGHT = {f"{axis}_{part}.gain": "20 %" for axis in "xy" for part in ("plant", "cross", "gain", "sum")}
BOTH = {
    "x": {"loop": "x", "figure": "phase_margin"},
    "peak": {"loop": "y", "figure": "sensitivity_peak"},
    "wide": {"loop": "x", "figure": "bandwidth"},
}


def phase_margin(gain: float) -> float:
    return 90.0 - 1.5 * math.degrees(2.0 * math.asin(gain * 1e-3 / 2.0))


@pytest.mark.exhaustive
def test_the_worst_corner_is_that_of_the_closed_form() -> None:
    found = worst(GRAPH, PHASE, tolerances={"controller.gain": "10 %", "plant.gain": "0.2 1/s"}, samples=20)
    (case,) = found.cases
    assert case.nominal == pytest.approx(phase_margin(100.0))
    assert case.worst == pytest.approx(phase_margin(110.0 * 1.2), rel=1e-9)
    assert case.values == pytest.approx({"controller.gain": 110.0, "plant.gain": 1.2})
    assert not case.inside
    assert found.all_corners
    assert case.one_at_a_time[0].at_high == pytest.approx(phase_margin(110.0), rel=1e-9)
    slope = -math.degrees(1.5e-3 / math.sqrt(1.0 - 0.05**2))
    assert case.first_order == pytest.approx(phase_margin(100.0) + slope * (10.0 + 20.0), rel=1e-9)
    assert found.unseen == pytest.approx(1.0 - 0.05 ** (1.0 / 20.0))
    assert "132.09" not in worst_text(found)
    assert "at a corner" in worst_text(found)


def test_without_named_loops_those_of_the_wires_are_taken() -> None:
    found = worst(GRAPH.changed(loops={}), tolerances={"controller.gain": "10 %"}, samples=1)
    gain, phase = found.cases
    assert (gain.name, phase.name) == ("computing.output.gain_margin", "computing.output.phase_margin")
    assert phase.worst == pytest.approx(phase_margin(110.0), rel=1e-9)
    with pytest.raises(ModelError, match="no loop") as caught:
        worst(read_graph_text(OPEN), tolerances={"gain.gain": "10 %"})
    assert "--measure NAME" in caught.value.problems[0].hint


@pytest.mark.defect(
    "H921", before="to name a quantity, where a loop had no delay", after="the cure of the graph's problem"
)
def test_a_graph_that_cannot_run_has_the_cure_of_its_problem() -> None:
    closed = OPEN.replace("source.output -> gain.input", "gain.output -> gain.input")
    with pytest.raises(ModelError, match="algebraic loop") as caught:
        worst(read_graph_text(closed), tolerances={"gain.gain": "5 %"})
    assert "put a UnitDelay" in caught.value.problems[0].hint


def test_a_loop_that_gets_unstable_is_the_worst() -> None:
    found = worst(GRAPH, PHASE, tolerances={"controller.gain": [50.0, 1300.0]}, samples=10)
    assert found.cases[0].worst is None
    assert found.cases[0].values["controller.gain"] == 1300.0
    assert "unstable at worst" in worst_text(found)


BESIDE_A_LOOP = """\
name = "a gain beside a loop that grows"
rate = "1 kHz"
samples = 20
wires = [
    "source.output -> sum.first", "back.output -> sum.second", "sum.output -> delay.input",
    "delay.output -> back.input", "source.output -> beside.input",
]
loops.main.open_at = "back.output"
measures.level = { signal = "beside.output", statistic = "last" }
measures.grown = { signal = "back.output", statistic = "last" }
blocks.source = { kind = "Constant", value = 1 }
blocks.sum = { kind = "Sum" }
blocks.delay = { kind = "Delay", ticks = 1 }
blocks.back = { kind = "Gain", gain = 0.98 }
blocks.beside = { kind = "Gain", gain = 2 }
"""


@pytest.mark.defect("S987", before="no value of a measure where a loop beside it is unstable", after="that of the run")
def test_measures_of_runs_have_values_beside_an_unstable_loop() -> None:
    """Of 20 ticks the last adds up b + b^2 ... b^19, at b = 0.98 x 1.05 = 1.029, where the loop is unstable."""
    graph, margin = read_graph_text(BESIDE_A_LOOP), {"margin": {"loop": "main", "figure": "gain_margin"}}
    quantities = {"level": {"measure": "level"}, "grown": {"measure": "grown"}, **margin}
    found = worst(graph, quantities, tolerances={"beside.gain": "5 %", "back.gain": "5 %"}, samples=3)
    values = {case.name: case.worst for case in found.cases}
    assert values["level, lowest"] == pytest.approx(1.9)
    assert values["level, highest"] == pytest.approx(2.1)
    assert values["grown, highest"] == pytest.approx(sum(1.029**n for n in range(1, 20)))
    assert values["margin"] is None


@pytest.mark.defect("S1034", before="a largest gain of 9.95, of what grows", after="unstable, with its reason")
def test_a_response_of_what_grows_has_no_figure() -> None:
    """The graph names no loop, and x[n + 1] = 1.1 x[n] + u[n] has formally a gain of 10 at rest."""
    text = BESIDE_A_LOOP.replace('loops.main.open_at = "back.output"\n', "").replace("gain = 0.98", "gain = 1.1")
    figure = {"input": "source.output", "response": "back.output", "figure": "peak"}
    found = worst(read_graph_text(text), {"peak": figure}, tolerances={"back.gain": "1 %"}, samples=3)
    assert "what source.output does to back.output grows without end" in worst_text(found)
    assert [case.worst for case in found.cases] == [None]


def test_a_response_of_two_integrators_has_its_gain() -> None:
    """Both poles are at 1, where rounding may put them outside: 1 / (2 sin(w / 2))^2 = 1 / 4 at half the rate."""
    text = """
name = "integrators"
rate = "1 kHz"
samples = 20
wires = ["source.output -> sum.first", "one.output -> sum.second", "sum.output -> one.input",
         "one.output -> all.first", "two.output -> all.second", "all.output -> two.input"]
blocks.source = { kind = "Constant", value = 1 }
blocks.sum = { kind = "Sum" }
blocks.one = { kind = "Delay", ticks = 1 }
blocks.all = { kind = "Sum" }
blocks.two = { kind = "Delay", ticks = 1 }
"""
    figure = {"input": "source.output", "response": "two.output", "figure": "gain", "frequency": "500 Hz"}
    found = worst(read_graph_text(text), {"gain": figure}, tolerances={"source.value": "1 %"}, samples=1)
    assert [case.worst for case in found.cases] == [pytest.approx(0.25)] * len(found.cases)


@pytest.mark.exhaustive
def test_a_worst_case_inside_is_found_where_no_corner_is() -> None:
    text = COUPLED.replace("gain = 0.6", "gain = 0.0").replace("gain = 200.0", "gain = 300.0")
    graph, quantity = read_graph_text(text), {"high": {"loop": "x", "figure": "bandwidth"}}
    tolerances: dict[str, Any] = {"x_cross.gain": [-0.9, 0.9], "y_cross.gain": [-1.0, 1.0]}
    found = worst(graph, quantity, tolerances=tolerances, samples=30)
    rows = itertools.product(np.linspace(-0.9, 0.9, 7), np.linspace(-1.0, 1.0, 7))
    dense = [values_at(graph, quantity, {"x_cross.gain": x, "y_cross.gain": y})["high"] for x, y in rows]
    known = min(value for value in dense if value is not None)
    assert found.cases[0].worst is not None
    assert found.cases[0].worst <= known * (1.0 + 1e-9)


def values_at(graph: Any, quantities: dict[str, Any], values: dict[str, float]) -> dict[str, float | None]:
    """Quantities at some parameters, evaluated alone."""
    from proofmass.graphs.model.flatten import flatten
    from proofmass.graphs.model.quantities import read_quantity_of

    wanted = {name: read_quantity_of(table, flatten(graph)) for name, table in quantities.items()}
    readings = Evaluator(graph, wanted, "", {}).readings(values, slopes=False)
    return {name: reading.value if (reading := readings[name]) else None for name in quantities}


def brute(points: list[tuple[float, ...]], found: WorstCases) -> None:
    """No point is worse than the worst case that was found."""
    from proofmass.graphs.model.flatten import flatten
    from proofmass.graphs.model.quantities import read_quantity_of

    wanted = {name: read_quantity_of(table, flatten(COUPLED_GRAPH)) for name, table in BOTH.items()}
    evaluator = Evaluator(COUPLED_GRAPH, wanted, "", {})
    cases = {case.name: case for case in found.cases}
    for point in points:
        values = {r.name: r.at(part) for r, part in zip(found.ranges, point, strict=True)}
        readings = evaluator.readings(values, slopes=False)
        for name, case in cases.items():
            reading = readings[name]
            if reading is None:
                assert case.worst is None
            elif case.worst is not None:
                sign = 1.0 if case.side == "lowest" else -1.0
                assert sign * (reading.value - case.worst) >= -1e-6 * abs(case.worst), (name, point)


def few() -> dict[str, str]:
    return dict.fromkeys(("x_gain.gain", "y_gain.gain", "x_cross.gain", "y_cross.gain"), "20 %")


@pytest.mark.exhaustive  # test_brute_force.py has another such system in every run of the tests
def test_brute_force_over_corners_and_middles_finds_nothing_worse() -> None:
    found = worst(COUPLED_GRAPH, BOTH, tolerances=few(), samples=20)
    grid = list(itertools.product((-1.0, 0.0, 1.0), repeat=4))
    brute(grid, found)


@pytest.mark.exhaustive
def test_brute_force_over_eight_parameters_finds_nothing_worse() -> None:
    names = ("x_gain", "y_gain", "x_cross", "y_cross", "x_plant", "y_plant")
    tolerances: dict[str, Any] = {f"{name}.gain": "15 %" for name in names}
    found = worst(COUPLED_GRAPH, BOTH, tolerances=tolerances, corners=0)
    brute(list(itertools.product((-1.0, 0.0, 1.0), repeat=6)), found)
    brute([tuple(row) for row in np.random.default_rng(8).uniform(-1.0, 1.0, (2000, 6))], found)


def test_ranges_are_those_of_the_study_and_of_tolerances() -> None:
    text = INTEGRATING + (
        '\n[study]\nmargins = "0 s"\n[study.spread]\n"controller.gain" = { normal = "1 %", relative = true }\n'
        '"plant.gain" = { uniform = 0.25 }\n'
    )
    study = read_study_text(text)
    known = {r.name: (r.low, r.high) for r in box_of(study, {}).ranges}
    assert known["controller.gain"] == pytest.approx((97.0, 103.0)), "three standard deviations"
    assert known["plant.gain"] == pytest.approx((0.75, 1.25))
    wider = {r.name: (r.low, r.high) for r in box_of(study, {"controller.gain": "50 %"}).ranges}
    assert wider["controller.gain"] == pytest.approx((50.0, 150.0))


@pytest.mark.parametrize(
    ("tolerances", "words"),
    [
        ({}, "nothing varies"),
        ({"controller.gian": "5 %"}, "did you mean gain"),
        ({"controller.gain": "5 V"}, "V is"),
        ({"controller.gain": [1.0, 2.0]}, "does not hold the value"),
        ({"controller.gain": "0 %"}, "no room"),
        ({"controller.gain": [None]}, "not a tolerance"),
        ({"hiss.density": "200 %"}, "does not take all of its range"),
    ],
)
def test_a_mistake_is_named(tolerances: dict[str, Any], words: str) -> None:
    with pytest.raises(ModelError) as told:
        worst(GRAPH, PHASE, tolerances=tolerances)
    assert any(words in str(problem) for problem in told.value.problems), told.value


@pytest.mark.exhaustive
def test_noise_scale_factor_and_measures_have_worst_cases_too() -> None:
    quantities = {
        "noise": {"noise": "plant.output"},
        "scale": {"scale_factor": "plant.output", "input": "wanted.output"},
        "top": {"measure": "top"},
    }
    found = worst(GRAPH, quantities, tolerances={"controller.gain": "20 %"}, samples=5)
    names = [case.name for case in found.cases]
    assert names == ["noise", "scale, lowest", "scale, highest", "top, lowest", "top, highest"]
    noise, top = found.cases[0], found.cases[-1]
    assert noise.values["controller.gain"] == 120.0, "a faster loop is noisier"
    assert top.worst == max(values_at(GRAPH, quantities, {"controller.gain": g})["top"] or 0.0 for g in (80, 100, 120))
    assert len(plot_worst(found).axes) == 5


def test_ctrl_c_keeps_the_worst_so_far() -> None:
    def press(done: int, _: int) -> None:
        if done == 4:
            os.kill(os.getpid(), signal.SIGINT)

    found = worst(COUPLED_GRAPH, BOTH, tolerances=few(), progress=press)
    assert found.interrupted
    assert found.evaluations <= 6
    assert "interrupted" in worst_text(found)


@pytest.mark.exhaustive
@pytest.mark.defect("S89", before="the worst of values above 5e5 is any of them", after="the largest")
def test_large_values_have_an_order() -> None:
    """The scale factor is gain / stiffness: 1e7 V/m over 4.5 N/m at most."""
    quantity = {"scale": {"scale_factor": "readout.voltage", "input": "force.output"}}
    tolerances: dict[str, Any] = {"readout.gain": [1e6, 1e7], "sensor.stiffness": "10 %"}
    found = worst(read_graph_text(RESONATOR), quantity, tolerances=tolerances, samples=3)
    assert found.cases[1].worst == pytest.approx(1e7 / 4.5)


@pytest.mark.parametrize(("points", "unseen"), [(0, 1.0), (1, 0.95), (59, 0.0495), (299, 0.00997)])
def test_the_part_of_the_box_that_random_points_may_miss(points: int, unseen: float) -> None:
    """Wilks: 59 points show 95 % of it with a confidence of 95 %, and 299 points 99 %."""
    assert WorstCases((), (), 0, points, points, False, {}).unseen == pytest.approx(unseen, rel=2e-3)


@pytest.mark.defect("S827", before="80.11 deg", after="79.68 deg")
def test_derivatives_count_to_the_end_of_a_range_that_is_not_symmetric() -> None:
    """Of ends that are 10 below and 20 above, the mean of both was taken, 15."""
    found = worst(GRAPH, PHASE, tolerances={"controller.gain": [90.0, 120.0]}, samples=1)
    slope = -math.degrees(1.5e-3 / math.sqrt(1.0 - 0.05**2))
    assert found.cases[0].first_order == pytest.approx(phase_margin(100.0) + slope * 20.0, rel=1e-9)


@pytest.mark.defect("C866", before="ValueError: max() arg is an empty sequence", after="corners alone")
def test_no_random_points_are_tried_where_none_are_wanted() -> None:
    found = worst(GRAPH, PHASE, tolerances={"controller.gain": "10 %"}, samples=0)
    assert found.cases[0].worst == pytest.approx(phase_margin(110.0), rel=1e-9)
    assert (found.random, found.unseen) == (0, 1.0)


@pytest.mark.exhaustive
@pytest.mark.defect("S975", before="`unstable at worst` of a graph without a loop", after="no value, and why")
def test_a_figure_without_a_value_says_why() -> None:
    """A gain of 0 passes nothing: there is no response."""
    wanted = {"peak": {"response": "gain.output", "input": "source.output", "figure": "peak"}}
    found = worst(read_graph_text(OPEN), wanted, tolerances={"gain.gain": [0.0, 2.0]}, samples=1)
    (case,) = found.cases
    reason = "source.output does not move gain.output"
    assert (case.worst, case.values) == (None, {"gain.gain": 0.0})
    assert worst_text(found).splitlines()[:2] == ["peak: 1 nominal, no value at worst, at a corner", f"  {reason}"]
    assert case.as_data()["without_value"] == {"worst": reason, "gain.gain, low": reason}
    (panel,) = plot_worst(found).axes
    assert panel.get_title(loc="left") == "peak: 1 nominal, no value at worst"


@pytest.mark.defect("S977", before="no value of a run that lanes do not take", after="that of the run alone")
def test_measures_of_runs_that_no_lane_takes_are_those_of_the_run_alone() -> None:
    """Other frequencies are those of more filters, whose states take more room."""
    graph = read_graph_text(FLICKER)
    evaluator = Evaluator(graph, {"last": MeasureOf("last", "1")}, "", {"noise.lowest_frequency": 1e-4})
    for lowest in (1e-4, 1e-6):
        reading = evaluator.readings({"noise.lowest_frequency": lowest}, slopes=False)["last"]
        alone = simulate(graph.with_parameters({"noise.lowest_frequency": lowest})).measures["last"]
        assert reading is not None
        assert reading.value == alone.value != 0.0


@pytest.mark.defect("S975", before="a run that fails has `no value` alone", after="the words of the run")
def test_a_run_that_fails_says_why() -> None:
    """1e308 / s times 1e3 s is beyond all numbers."""
    evaluator = Evaluator(read_graph_text(FLICKER), {"end": MeasureOf("end", "1")}, "", {"rise.slope": 1.0})
    assert evaluator.readings({"rise.slope": 1e308}, slopes=False) == {"end": None}
    assert evaluator.why["end"].reason.startswith("rise.output is not finite in tick")


@pytest.mark.defect("S983", before="an infinite end had no value at worst", after="refused")
@pytest.mark.parametrize("ends", [[1.0, math.inf], [-math.inf, 200.0], [1.0, math.nan]])
def test_ends_of_a_tolerance_are_finite(ends: list[float]) -> None:
    with pytest.raises(ModelError, match="must be finite"):
        worst(GRAPH, PHASE, tolerances={"controller.gain": ends})
