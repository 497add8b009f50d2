"""Estimation and compensation of the loop gains against the numbers of Ran et al. 2019, each with its label.

[P] is in the paper, [D] follows from its figures, [A] is an assumption, [C] a conjecture that fits.
"""

import math

import numpy as np
import pytest

from docs.quartz_accelerometer import (
    CODES_PER_AMPERE,
    FEEDBACK_CURRENT,
    MICRO_G,
    SCALE_FACTOR,
    TABLE_3,
    TABLE_4,
    at_end,
    disturbed,
    ideal,
    library,
    ppm,
    run,
    scatter,
    study,
    with_converter,
)
from proofmass.blocks.sine import Sine
from proofmass.graphs.graph import Graph
from proofmass.runner.engine.simulate import simulate
from proofmass.runner.studies.study import run_study
from tests.runner.test_engines_agree import assert_same_bits


def test_references_of_both_gains() -> None:
    """478.974 and -71738.85, the means of Tables 3 and 4 [D], from one natural parameter set [A]."""
    assert ideal().forward[0] == pytest.approx(np.mean(TABLE_3, axis=0)[0], abs=5e-4)
    assert ideal().feedback[0] == pytest.approx(np.mean(TABLE_4, axis=0)[0], abs=5e-3)


def test_ideal_estimates_within_0_1_ppm() -> None:
    """-200 and +200 ppm as they were moved [P], in the procedure and in the graph of each estimate alone."""
    assert ppm(ideal().forward) == pytest.approx(-200.0, abs=0.1)
    assert ppm(ideal().feedback) == pytest.approx(200.0, abs=0.1)
    for name, moved in (("quartz_forward_gain", -200e-6), ("quartz_feedback_gain", 200e-6)):
        assert at_end(run(name), "estimator.deviation") == pytest.approx(moved, abs=1e-7)


def test_the_study_without_disturbances_keeps_its_limits() -> None:
    wanted = study("quartz_drift_study")
    assert wanted.limits.keys() == {"forward_deviation", "feedback_deviation", "error_before", "error_after"}
    result = run_study(wanted, engine="compiled")
    assert result.yields()["all limits"] == 1.0
    assert abs(result["error_after"]).max() < 1.0 * MICRO_G


def test_what_was_estimated_is_compensated() -> None:
    """Eq. 22 and 30: k(D(z)) and N_VREF go up by 200 ppm; both gains are then as they were."""
    result = run("quartz_calibration")
    assert at_end(result, "sequencer.step") == 7.0
    assert at_end(result, "k_d.value") == pytest.approx(1.0 / (1.0 - 200e-6), abs=1e-7)
    assert at_end(result, "n_vref.value") / 524288.0 == pytest.approx(1.0 + 200e-6, abs=1e-7)


def test_figure_13() -> None:
    """About 200 ug before (paper 193 [P]); at most 1 ug after (paper 24 [P], from an estimate 18 ppm too large)."""
    before, after = ideal().errors
    assert before == pytest.approx(200.0, abs=0.1)
    assert after == pytest.approx(-0.3, abs=0.1)
    gone = run("quartz_calibration", {"forward_change.value": 0.0, "feedback_change.value": 0.0})
    assert at_end(gone, "error_before.output") == pytest.approx(0.0, abs=0.05 * MICRO_G)


@pytest.mark.parametrize(("bits", "after"), [(16, -13.6), (18, 1.65), (20, -0.3)])
def test_steps_of_the_reference_converter(bits: int, after: float) -> None:
    """Rounding of N_VREF to 30.5, 7.6 and 1.9 ppm leaves what arithmetic says."""
    wanted = (1 << (bits - 1)) * (1.0 + 200e-6)
    assert with_converter(bits).errors[1] == pytest.approx((wanted / round(wanted) - 1.0) * 1e6, abs=0.1)
    assert with_converter(bits).errors[1] == pytest.approx(after, abs=0.1)


def test_the_rows_of_the_paper() -> None:
    """Means -180.52 and 218.15 ppm, 3.92 and 4.85 ppm of scatter [D]: 12 and 9 standard errors off what was moved."""
    for rows, moved, mean, std, errors in ((TABLE_3, -200.0, -180.52, 3.92, 12), (TABLE_4, 200.0, 218.15, 4.85, 9)):
        found = [ppm(row) for row in rows]
        assert np.mean(found) == pytest.approx(mean, abs=0.01)
        assert np.std(found, ddof=1) == pytest.approx(std, abs=0.01)
        assert abs(mean - moved) / (std / math.sqrt(6)) == pytest.approx(errors, abs=0.5)


def test_disturbed_trials_come_out_as_the_paper_s() -> None:
    """A resistor of the amplifier, not its gain: -180 ppm; a source 2 K warmer: +218 ppm; over-compensation [C].

    The mean of six is compared within three standard errors of what the disturbances make, the scatter within a factor.
    """
    forward, feedback = ([ppm(getattr(t, name)) for t in disturbed()] for name in ("forward", "feedback"))
    assert np.mean(forward) == pytest.approx(-180.0, abs=3 * 3.9 / math.sqrt(6))
    assert np.mean(feedback) == pytest.approx(218.0, abs=3 * 5.0 / math.sqrt(6))
    assert 3.92 / 2.2 < np.std(forward, ddof=1) < 3.92 * 2.2
    assert 4.85 / 2.2 < np.std(feedback, ddof=1) < 4.85 * 2.2
    after = [t.errors[1] for t in disturbed()]
    assert np.mean(after) == pytest.approx(-17.4, abs=8.0)
    assert max(after) < 0.0
    assert min(after) > -24.0  # [P]
    assert len({trial.errors for trial in disturbed()}) == 6  # each with noise of its own


@pytest.mark.parametrize(
    ("seconds", "once", "chopped"), [(20, 5.0, 4.6), (100, 4.3, 1.8), (400, 7.9, 0.85), (2000, 17.0, 0.37)]
)
def test_patience_pays_only_with_a_pattern(seconds: int, once: float, chopped: float) -> None:
    """Longer averages of one on and one off get worse; chopping every 5 s, and ABBA, follow the white noise [C].

    The reference values come from a few tens of draws each, hence 40 %.
    """
    white = 10.0 * math.sqrt(2.0 / seconds) * MICRO_G * -SCALE_FACTOR / 71738.85 * 1e6
    assert scatter(seconds, "once") == pytest.approx(once, rel=0.4)
    for pattern in ("chopped", "ABBA"):
        assert scatter(seconds, pattern) == pytest.approx(chopped, rel=0.42)
        assert 0.9 * white < scatter(seconds, pattern) < 1.6 * white


def test_scatter_of_one_on_and_one_off_against_its_formula() -> None:
    """White noise S and random walk q alone, means over T each: variance S^2 / T + 2 q^2 T / 3 between neighbours."""
    quiet: dict[str, object] = {"flicker.level": 0.0, "slots.slots": 2, "slots.settling": 0.0, "slots.averaging": 9.9}
    result = run("quartz_feedback_noise", quiet, duration=4000 * 20 + 1)
    found = result["estimator.difference"].values[np.flatnonzero(result["estimator.estimated"].values)]
    variance = 10.0**2 / 9.9 + 2.0 / 3.0 * 0.5**2 * 10.0  # ug^2
    assert np.std(found) == pytest.approx(math.sqrt(variance) * MICRO_G * -SCALE_FACTOR, rel=0.04)


def test_the_graph_of_long_averages_is_the_loop() -> None:
    """A slow acceleration, chopped: the loop and its scale factor, here at 10 kHz, give the same within 1 ppm."""
    wave = Sine(amplitude=2e-3, frequency=0.23, unit="m/s^2")
    rows: dict[str, object] = {"slots.slots": 4, "slots.averaging": 0.7}
    quiet = {"random_walk.coefficient": 0.0, "flicker.level": 0.0, "white.density": 0.0}
    static = library("quartz_feedback_noise").with_parameters(rows | quiet | {"slots.settling": 0.2})
    quick = Graph(
        name="static",
        blocks={**static.blocks, "wave": wave},
        wires=[*static.wires, "wave.output -> force.third"],
        probes=["estimator.difference"],
        rate="10 kHz",
    )
    loop = Graph(
        name="loop",
        blocks={
            "wave": Sine(amplitude=2e-3, frequency=0.23, offset=9.80665, unit="m/s^2"),
            "loop": library("quartz_feedback_gain").with_parameters(rows | {"slots.settling": 0.20008}),  # same slots
        },
        wires=["wave.output -> loop.accelerometer.specific_force.value"],
        probes=["loop.estimator.difference"],
        rate="50 kHz",
    )
    found = at_end(simulate(loop, duration="3.7 s", engine="compiled"), "loop.estimator.difference")
    expected = at_end(simulate(quick, duration="3.7 s", engine="compiled"), "estimator.difference")
    assert abs(expected + FEEDBACK_CURRENT * CODES_PER_AMPERE) > 1.0  # the wave is in it
    assert found == pytest.approx(expected, rel=1e-6)


def test_both_engines_through_every_step() -> None:
    short: dict[str, object] = {"sweep_slots.settling": 0.0, "sweep_slots.averaging": 4e-5}
    short |= {f"{part}.{time}": 4e-3 for part in ("switch_slots", "test_slots") for time in ("settling", "averaging")}
    graph = library("quartz_calibration").with_parameters(short)
    assert at_end(simulate(graph, engine="compiled", samples=3000), "sequencer.step") == 7.0
    assert_same_bits(graph, 3000)


def test_current_of_the_source() -> None:
    """I_ref 1.0002266 mA is 0.829 g [D]."""
    g_of_current = FEEDBACK_CURRENT * 0.065 / 8.0e-6 / 9.80665
    assert g_of_current == pytest.approx(0.829, abs=5e-4)
