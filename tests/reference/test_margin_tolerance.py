"""The study of margins under tolerance: each sensor's margins by a dense sweep of the formula of its own loop."""

import math
import shutil
from typing import Any

import numpy as np
import pytest

from proofmass.graphs.files.library import library_file
from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.studies.draws.factors import Drawn
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.sensitivities import regression
from proofmass.runner.studies.whole.study import run_study
from tests.by_hand.accelerometer_loop import open_loop

RUNS = 24


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> StudyResult:
    """The study on a shorter run, which its margins at 0 s do not see."""
    folder = tmp_path_factory.mktemp("margins")
    text = library_file("scale_factor_drift.toml").read_text()
    short = text.replace('duration = "0.3 s"', 'duration = "1 ms"').replace('from = "0.25 s"', 'from = "0 s"')
    (folder / "scale_factor_drift.toml").write_text(short)
    shutil.copy(library_file("margin_tolerance_study.toml"), folder / "study.toml")
    return run_study(read_study(folder / "study.toml"), runs=RUNS, engine="python")


def loop(study: Study, run: int, w: Any) -> Any:
    """L(exp(j w T)) of a sensor in closed form."""
    drawn = study.drawn(run)[0]
    inertia, damping, stiffness = (drawn[f"pendulum.{name}"] for name in ("inertia", "damping", "stiffness"))
    converters = 2.0**23 / drawn["adc.reference"] * drawn["reference.value"] / 2.0**19
    gain = drawn["pickoff.gain"] * converters * drawn["resistor.gain"] * drawn["torquer.gain"]
    return open_loop(w, inertia, damping, stiffness, gain)


@pytest.mark.exhaustive
def test_every_sensor_has_the_margins_of_its_own_loop(result: StudyResult) -> None:
    w = 2.0 * math.pi * np.geomspace(20.0, 24_990.0, 200_000)
    for run in range(RUNS):
        response = loop(result.study, run, w)
        phase, size = np.unwrap(np.angle(response)), np.abs(response)
        crossing = np.flatnonzero(np.diff(np.sign(phase + math.pi)))
        assert result["main.gain_margin"][run, 0] == pytest.approx(-20.0 * math.log10(size[crossing].max()), abs=2e-3)
        unity = np.flatnonzero(np.diff(np.sign(size - 1.0)))
        margin = np.degrees(math.pi + phase[unity]).min()
        assert result["main.phase_margin"][run, 0] == pytest.approx(margin, abs=0.02)
        modulus_margin = np.abs(1.0 + response).min()
        assert result["main.sensitivity_peak"][run, 0] == pytest.approx(-20.0 * math.log10(modulus_margin), abs=1e-4)


@pytest.mark.exhaustive
def test_its_yield_is_the_part_that_keeps_the_limits(result: StudyResult) -> None:
    kept = result["main.gain_margin"][:, 0] >= 30.0
    assert 0.0 < kept.mean() <= 1.0
    assert result.yields()["main.gain_margin"] == kept.mean()
    assert result.yields()["main.stable"] == 1.0


@pytest.mark.exhaustive
def test_the_pickoff_and_what_stands_outside_the_loop(result: StudyResult) -> None:
    """A decibel of gain is a decibel of margin; pendulosity scales what is measured, and not the loop."""
    found = regression(Drawn(result.study, result.numbers).factors(0).columns, result["main.gain_margin"][:, 0])
    assert found is not None
    slopes = {influence.parameter: influence.slope for influence in found.influences}
    assert slopes["pickoff.gain"] == pytest.approx(-20.0 / math.log(10.0) / 8.0e3, rel=0.05)
    assert abs(slopes["pendulosity.gain"] * 8.0e-6 * 0.01) < 0.05  # dB for one per cent
