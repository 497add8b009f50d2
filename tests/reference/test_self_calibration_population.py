"""Self-calibration over a population: the published device does as in its own graph, and who fails is known."""

import numpy as np
import pytest

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.run.simulate import simulate
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.whole.study import run_study

STIFFNESS, DAMPING = 51.48, 4.57e-3  # of the device of Sarraf et al. (2012), table 1
DESIGNED = 3.4e-3


@pytest.fixture(scope="module")
def study() -> Study:
    return read_study(library_file("self_calibration_population.toml"))


@pytest.fixture(scope="module")
def result(study: Study) -> StudyResult:
    return run_study(study, runs=32, engine="compiled")


def test_the_published_device_is_calibrated_as_in_its_own_graph(study: Study) -> None:
    alone = simulate(read_graph(library_file("self_calibration_accelerometer.toml")), seed=7, engine="compiled")
    one = Study(
        study.graph, runs=1, seed=7, sweep={"true_stiffness.value": [STIFFNESS], "true_damping.value": [DAMPING]}
    )
    found = run_study(one, engine="compiled")
    stiffness, damping = (alone[f"{name}.{name}"].values[-1] for name in ("stiffness", "damping"))
    assert found["stiffness_error"][0, 0] == pytest.approx(stiffness - STIFFNESS, abs=1e-9 * STIFFNESS)
    assert found["damping_error"][0, 0] == pytest.approx(damping - DAMPING, abs=1e-9 * DAMPING)
    assert found["periods"][0, 0] == alone["monitor.periods"].values[-1]


@pytest.mark.exhaustive
def test_nearly_all_devices_find_themselves(result: StudyResult) -> None:
    assert not result.faults
    assert result.yields()["stiffness_error"] == 1.0
    assert 0.85 <= result.yields()["damping_error"] <= 1.0
    assert np.median(np.abs(result["stiffness_error"])) < 1e-3 * STIFFNESS
    assert np.median(np.abs(result["damping_error"])) < 1e-2 * DAMPING


def test_those_that_do_not_have_little_damping(result: StudyResult, study: Study) -> None:
    """The correction per period is the same for all, and the further the damping lies below, the longer it takes."""
    drawn = np.array([study.changed(runs=32, seed=study.seed).drawn(k)[0]["true_damping.value"] for k in range(32)])
    late = result["periods"][:, 0] > 1.5 * np.median(result["periods"])
    assert late.any()
    assert (drawn[late] < DESIGNED).all()
