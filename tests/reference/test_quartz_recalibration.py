"""Years of drift of the digital quartz accelerometer, with calibrations and without, against closed forms."""

import numpy as np
import pytest

from docs.papers.quartz_accelerometer import MICRO_G, SCALE_FACTOR, library, study
from proofmass.graphs.model.build import Graph
from proofmass.graphs.studies.build import Study
from proofmass.runner.analysis.margins.stability import all_margins
from proofmass.runner.planning.plan import plan
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.whole.study import run_study

YEAR = 31557600.0
AGES = (0.0, YEAR, 2.0 * YEAR, 3.0 * YEAR)
PACES = {  # ppm a year
    "accelerometer.da0.reference": 40.0,
    "accelerometer.da1.reference": -30.0,
    "accelerometer.adc.reference": 20.0,
    "accelerometer.converter.resistance": 25.0,
    "accelerometer.amplifier.feedback_resistance": 10.0,
    "accelerometer.reference_current.nominal": 5.0,
    "accelerometer.bridge.first_reference": 300.0,
    "accelerometer.pickoff.capacitance": 2000.0,
    "spacing.value": 1000.0,
}


@pytest.fixture(scope="module")
def years() -> StudyResult:
    """One sensor whose parts drift at known paces, never calibrated again, every two years and every year."""
    whole = study("quartz_recalibration_study")
    made = Study(
        library("quartz_recalibration"),
        runs=1,
        epochs={"ages": list(AGES)},
        drift={name: {"ramp": f"{pace} ppm/year", "relative": True} for name, pace in PACES.items()},
        recalibration={"every": ["never", "2 year", "1 year"], "carried": dict(whole.recalibration.carried)},
        margins="0 s",
    )
    return run_study(made, engine="compiled")


def drifted(name: str) -> np.ndarray:  # type: ignore[type-arg]
    return 1.0 + 1e-6 * PACES[name] * np.array(AGES) / YEAR


@pytest.mark.exhaustive
def test_what_is_found_has_drifted_since_the_last_calibration(years: StudyResult) -> None:
    """K0 / (kt kVI kDA) goes with R / V_ref; a calibration takes that off, but for the drift of I_ref, which it
    cannot see, and for half a step of DA0 in each of the two roundings, 1.9 ppm."""
    gain = drifted("accelerometer.converter.resistance") / drifted("accelerometer.da0.reference")
    current = drifted("accelerometer.reference_current.nominal")
    for place, last in enumerate(([0, 0, 0, 0], [0, 0, 0, 2], [0, 0, 1, 2])):
        expected = SCALE_FACTOR * gain / gain[last] / (current[last] / current[0])
        assert years["scale_factor"][place] == pytest.approx(expected, rel=2.5e-6)
        left = SCALE_FACTOR / (current / current[0])
        assert years["scale_factor_left"][place] == pytest.approx(left, rel=2.5e-6)
    never = years["scale_factor"][0]
    assert never == pytest.approx(SCALE_FACTOR * gain, rel=0.3e-6)  # nothing is rounded anew


@pytest.mark.exhaustive
def test_registers_hold_what_makes_up_for_the_drift(years: StudyResult) -> None:
    """k_D for everything in the attached bridge and behind it: the capacitances are not there, nor is the spacing."""
    dc = 42.590865 * drifted("accelerometer.bridge.first_reference")
    balance = (1.0 - dc / (dc + 42.409135)) / (1.0 - 42.590865 / 85.0)
    amplifier = 1.0 + 9.0 * drifted("accelerometer.amplifier.feedback_resistance")
    forward = (
        drifted("accelerometer.da1.reference") / drifted("accelerometer.adc.reference") * balance * amplifier / 10.0
    )
    for place in range(3):
        assert years["k_d"][place] == pytest.approx(1.0 / forward, rel=1e-6)
    feedback = drifted("accelerometer.converter.resistance") / drifted("accelerometer.da0.reference")
    current = drifted("accelerometer.reference_current.nominal")
    assert years["n_vref"][2] / 524288.0 == pytest.approx(feedback * current, rel=2.5e-6)
    assert np.ptp(years["slope"]) == np.ptp(years["difference"]) == 0.0  # the references of the factory


@pytest.mark.exhaustive
def test_bias_is_that_of_the_reference_capacitors_whatever_is_calibrated(years: StudyResult) -> None:
    """D (r - 1/2) 2 d / l / K0, which no calibration of gains moves."""
    first = 42.590865 * drifted("accelerometer.bridge.first_reference")
    tilt = (first / (first + 42.409135) - 0.5) * 2.0 * 12.5e-6 * drifted("spacing.value") / 10e-3
    for place in range(3):
        assert years["bias"][place] == pytest.approx(-3.0e-3 * tilt / 8.0e-6, abs=0.2 * MICRO_G)


@pytest.mark.exhaustive
def test_margins_at_each_epoch_are_those_of_the_aged_graph(years: StudyResult) -> None:
    sensors = years.study
    for place, epoch in ((0, 3), (2, 3), (1, 2)):
        carried = {"k_d.initial": 1.0, "n_vref.initial": 524288.0}
        calibrated = [n for n in range(epoch) if sensors.calibrated(place)[n]]
        carried |= {f"{name}.initial": years[name][place, calibrated[-1]] for name in ("k_d", "n_vref")}
        aged = sensors.drawn(place)[epoch] | carried
        found = _margins(library("quartz_recalibration").with_parameters(aged))
        assert years["main.gain_margin"][place, epoch] == pytest.approx(found["gain_margin_db"], rel=1e-9)
        assert years["main.phase_margin"][place, epoch] == pytest.approx(found["phase_margin_deg"], rel=1e-9)
        assert years["main.stable"][place, epoch] == 1.0
    assert np.ptp(years["main.gain_margin"]) > 0.01


def _margins(graph: Graph) -> dict[str, float]:
    return all_margins(plan(graph))["main"].as_data()


@pytest.mark.exhaustive
def test_the_study_of_ten_years() -> None:
    """Every month of ten years at three intervals; its drift is that of the parts, whose two ends see one spacing."""
    made = study("quartz_recalibration_study")
    assert len(made.epochs) == 121
    assert [made.calibrated(run).count(True) for run in range(3)] == [1, 11, 121]
    object.__setattr__(made, "epochs", made.epochs[:2])
    result = run_study(made, runs=1, engine="compiled")
    assert not result.faults
    assert result["scale_factor"].shape == (3, 2)
