"""Predicted densities within the 99 % band of the spectra of runs; `benchmarks.noise_budgets` has them all."""

import pytest

from benchmarks.noise_comparison import CASES, Case, row

FAST = ("recorded_motion.toml", "quartz_feedback_noise.toml", "temperature_compensation_m1.toml")


@pytest.mark.exhaustive("mean.mean", "force.output", "output.output", "noisy.output")
@pytest.mark.parametrize("case", [case for case in CASES if case.file.endswith(FAST)], ids=lambda case: case.output)
def test_lines_are_as_likely_as_they_should_be(case: Case) -> None:
    found = row(case)
    assert found.inside >= 0.95
    if found.budget.band[0] == 0.0:  # else it wanders, and its rms is that of the length of the run
        assert found.rms == pytest.approx(found.budget.rms, rel=0.03)
