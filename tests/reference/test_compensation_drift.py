"""The study of a compensation whose accelerometer ages: its measures against the law in NumPy, and its yield."""

import numpy as np
import pytest

from proofmass.graphs.files.library import library_file
from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.studies.whole.study import run_study

FILE = library_file("temperature_compensation_drift.toml")
STUDY = read_study(FILE)
YEAR = 365.25 * 86400.0


def test_the_residual_of_an_aged_law_is_that_of_numpy() -> None:
    """One sensor without hysteresis and noise, its factors on straight laws: two exponentials less two others."""
    quiet = STUDY.graph.with_parameters({"accelerometer.hysteresis": 0.0, "amplifier.density": 0.0})
    drift = {
        "accelerometer.a1": {"logarithmic": "0.5 %", "onset": "100 h", "relative": True},
        "accelerometer.a2": {"ramp": "0.2 %/year", "relative": True},
    }
    study = Study(quiet, runs=1, epochs={"ages": ["0 h", "10 year"]}, drift=drift)
    found = run_study(study, engine="python")
    law, model = (quiet.blocks[name] for name in ("accelerometer", "model"))
    volts = np.linspace(0.6, 1.8, 126)  # a kelvin a minute
    fitted = sum(getattr(model, f"a{i}") * np.exp(getattr(model, f"b{i}") * volts) for i in (1, 2))
    for epoch, factors in enumerate(((1.0, 1.0), (1.0 + 0.005 * np.log10(1.0 + 10 * YEAR / 360e3), 1.02))):
        aged = sum(
            factor * getattr(law, f"a{i}") * np.exp(getattr(law, f"b{i}") * volts)
            for i, factor in zip((1, 2), factors, strict=True)
        )
        assert found["compensated"][0, epoch] == pytest.approx(np.ptp(aged - fitted), rel=1e-4)
        assert found["uncompensated"][0, epoch] == pytest.approx(np.ptp(aged), rel=1e-4)
        assert found["in_fixed_point"][0, epoch] == pytest.approx(np.ptp(aged - fitted), abs=3e-6)


@pytest.mark.exhaustive
def test_what_compensation_leaves_grows_with_the_age() -> None:
    found = run_study(STUDY, runs=5, engine="python")
    assert not found.faults
    new, old = found["compensated"][:, 0], found["compensated"][:, -1]
    assert new == pytest.approx(np.full(5, 3.69e-4), rel=0.02)
    assert np.median(old) > np.median(found["compensated"][:, 1])
    assert old.std() > 5.0 * new.std()
    assert found["in_fixed_point"] == pytest.approx(found["compensated"], abs=4e-6)
    assert found.yields()["all limits"] == np.mean((found["compensated"] < 4.5e-4).all(axis=1))


@pytest.mark.exhaustive
def test_what_part_of_the_sensors_stays_within_its_limits() -> None:
    """The numbers of the document: of 100 sensors one is below 0.45 mV in floating point, and above it in registers."""
    found = run_study(STUDY, runs=100, engine="compiled")
    assert found.yields() == {"compensated": 0.83, "in_fixed_point": 0.82, "all limits": 0.82}
