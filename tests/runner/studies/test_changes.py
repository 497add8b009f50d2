"""Changes of measures since an age and since the last calibration, against closed forms; engines bit for bit."""

from pathlib import Path

import numpy as np
import pytest

from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.runner.studies.whole.study import replay, run_study
from tests.runner.studies.test_drift_influences import CALIBRATED

CHANGES = """
[study.changes]
since_new = { measure = "kept", relative = true }
since_one_year = { measure = "kept", since = "1 year" }
since_calibration = { measure = "error", since = "calibration" }
"""
TEXT = CALIBRATED.replace("runs = 400", "runs = 6") + CHANGES
NOISY = TEXT.replace("b.output -> raw.second", 'b.output -> raw.second", "noise.output -> raw.third').replace(
    "[blocks]", '[blocks]\nnoise = { kind = "WhiteNoise", density = "1e-3 1/sqrt(Hz)" }'
)


def test_changes_are_those_of_the_closed_form() -> None:
    """kept = 2 a + b, and right after a calibration the error is nought: its change is that of kept."""
    study = read_study_text(TEXT)
    result = run_study(study, engine="python")
    for place, run in enumerate(result.numbers.tolist()):
        kept = np.array([2.0 * at["a.value"] + at["b.value"] for at in study.drawn(run)])
        assert result["kept"][place] == pytest.approx(kept, rel=1e-14)
        assert result["since_new"][place] == pytest.approx(kept / kept[0] - 1.0, abs=1e-14)
        assert result["since_one_year"][place] == pytest.approx(kept - kept[1], abs=1e-14)
        last = [0, 0, 0, 2, 2, 4, 4, 6, 6, 8, 8, 10, 10, 12, 12, 14] if run % 2 else [0] * 16
        expected = kept - kept[last]
        expected[0] = 0.0
        assert result["since_calibration"][place] == pytest.approx(expected, abs=1e-14)


@pytest.mark.exhaustive
def test_engines_lanes_and_resuming_agree_to_the_bit(tmp_path: Path) -> None:
    study = read_study_text(NOISY)
    python = run_study(study, engine="python")
    for lanes in (0, 4):
        assert run_study(study, engine="compiled", lanes=lanes).digest == python.digest
    run_study(study, runs=2, engine="python", folder=tmp_path)
    again = run_study(study, engine="compiled", folder=tmp_path)
    assert again.digest == python.digest
    assert np.isfinite(again["since_calibration"]).all()


def test_the_run_after_a_calibration_has_noise_of_its_own() -> None:
    """A change of a quiet sensor is the difference of two noisy readings: sqrt(2) times their scatter."""
    still = NOISY.partition("[study.drift]")[0] + NOISY[NOISY.index("[study.recalibration]") :]
    study = read_study_text(still.replace("runs = 6", "runs = 3000"))
    result = run_study(study, engine="compiled")
    # error at one year = noise now - noise of the calibration; just after it = other noise - the same
    now = result["error"][1::2, 1]
    change = result["since_calibration"][1::2, 1]
    assert change.std() == pytest.approx(now.std(), rel=0.05)
    assert abs(np.corrcoef(change, now)[0, 1] - 0.5) < 0.05


def test_a_change_in_a_study_keeps_limits() -> None:
    limited = TEXT + "\n[study.limits]\nsince_calibration = { at_most = 1e-12 }\n"
    result = run_study(read_study_text(limited), engine="python")
    assert not result.kept("since_calibration").any()


def test_a_replay_has_the_changes_of_its_run() -> None:
    study = read_study_text(NOISY)
    result = run_study(study, engine="python")
    again = replay(study, 3, 5, "python").measures
    for name in study.changes:
        assert again[name].value == result[name][3, 5]
    assert again.keys() == set(result.values)
