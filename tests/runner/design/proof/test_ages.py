"""Proofs of studies: a parameter has all values that spread, sweep and drift make of it, at every age."""

import math

import pytest
import scipy.constants

from proofmass import prove, read_study, worst
from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.runner.design.proof.text import proofs_text
from proofmass.runner.design.worst.box import box_of
from tests.by_hand.design_texts import INTEGRATING

HOUR, YEAR = 3600.0, 365.25 * 24 * 3600.0
AGES = (0.0, 1000 * HOUR, YEAR, 2 * YEAR, 5 * YEAR, 10 * YEAR)
STUDY = '[study]\nruns = 40\nseed = 3\nmargins = "0 s"\n'


def test_a_drifting_parameter_has_all_that_its_laws_make_of_it() -> None:
    """The laws in closed form, each pace at three standard deviations, the value of the new sensor at its own ends."""
    study = read_study("library:scale_factor_drift")
    found = {r.written: (r.low, r.high) for r in box_of(study, {}).hulls()}
    energy = 0.7 * scipy.constants.e / scipy.constants.k
    faster = math.exp(energy * (1.0 / 298.15 - 1.0 / 328.0))
    paces = [(4e-6 + sign * 12e-6) * faster / YEAR for sign in (-1.0, 1.0)]
    expected = {"reference.value": _ends(2.5, 600e-6, [pace * age for pace in paces for age in AGES])}
    walks = [sign * 15e-6 * math.sqrt(age / YEAR) for sign in (-1.0, 1.0) for age in AGES]
    expected["resistor.gain"] = _ends(1.0 / 342.0, 100e-6, walks)
    slopes = [(-40e-6 + sign * 45e-6) * math.log10(1.0 + age / (100 * HOUR)) for sign in (-1.0, 1.0) for age in AGES]
    expected["torquer.gain"] = _ends(0.065, 1500e-6, slopes)
    assert {name: pytest.approx(ends, rel=1e-12) for name, ends in expected.items()} == found


def _ends(nominal: float, part: float, drifts: list[float]) -> tuple[float, float]:
    values = [nominal * (1.0 + sign * part) * (1.0 + drift) for sign in (-1.0, 1.0) for drift in drifts]
    return min(values), max(values)


def test_what_goes_up_and_down_with_the_age_is_within_from_its_ends_alone_and_from_between() -> None:
    """Up by the logarithm, down by the ramp: 10 lg(1 + t / d) - t / (100 d) is largest near 433 d, 22.1."""
    drift = '{ logarithmic = 10.0, onset = "1 d", ramp = "-0.01 1/d" }'
    text = f'[study.drift]\n"controller.gain" = {drift}\n[study.epochs]\nages = ["0 d", "1 d", "433 d", "9000 d"]\n'
    (gain,) = box_of(read_study_text(INTEGRATING + STUDY + text), {}).hulls()
    least, most = 100.0 + 10.0 * math.log10(9001.0) - 90.0, 100.0 + 10.0 * math.log10(434.0) - 4.33
    assert (gain.low, gain.high) == pytest.approx((least, most), rel=1e-12)


def test_drawn_sensors_lie_within_at_every_age() -> None:
    """Within three standard deviations of what is not truncated itself."""
    study = read_study("library:scale_factor_drift")
    ends = {r.name: (r.low, r.high) for r in box_of(study, {}).hulls()}
    drawn = [study.drawn(run)[epoch] for run in range(60) for epoch in range(len(AGES))]
    assert all(low <= each[name] <= high for each in drawn for name, (low, high) in ends.items())
    assert any(abs(each["reference.value"] / 2.5 - 1.0) > 600e-6 for each in drawn)  # more than the spread has


@pytest.mark.parametrize(("years", "status"), [(17, "proved"), (19, "refuted")])
def test_a_gain_that_grows_by_half_each_year_is_unstable_after_eighteen(years: int, status: str) -> None:
    """z^2 - z + K T has its poles on the unit circle at K T = 1, ten times the gain of the new sensor."""
    drift = '[study.drift]\n"controller.gain" = { ramp = "50 %/year", relative = true }\n'
    text = f'{INTEGRATING}{STUDY}{drift}[study.epochs]\nages = ["0 h", "{years} year"]\n'
    found = prove(read_study_text(text), gain_margin="30 dB", phase_margin="89 deg")  # which it has not when new
    assert found.proofs[0].status == status
    assert found.left_out == {}
    assert f"controller.gain from 100 to {100 + 50 * years}, at all ages" in proofs_text(found)


@pytest.mark.defect("H886", before="open: there is no such block as sweep", after="both act on one parameter")
def test_a_parameter_that_is_swept_and_spread_has_both() -> None:
    spread = '"controller.gain" = { uniform = 0.1, relative = true }'
    both = f'sweep = {{ "controller.gain" = [100.0, 200.0] }}\n[study.spread]\n{spread}\n'
    found = prove(read_study_text(INTEGRATING + STUDY + both), gain_margin="12.5 dB")
    assert [(r.written, r.low, r.high) for r in found.ranges] == [("controller.gain", 90.0, pytest.approx(220.0))]
    assert found.proved  # 1 / K T is 13.15 dB at 220
    assert not prove(read_study_text(INTEGRATING + STUDY + both), gain_margin="13.2 dB").proved


@pytest.mark.exhaustive
def test_ten_years_of_a_scale_factor_are_proved_a_little_beyond_what_a_search_along_ages_finds() -> None:
    study = read_study("library:scale_factor_drift")
    found = prove(study, input="acceleration.output", scale_factor={"dac.code": ""})
    least, most = (one.claim.limit for one in found.proofs)
    asked = worst(study, {"scale": {"scale_factor": "dac.code", "input": "acceleration.output"}}, samples=20)
    low, high = (case.worst for case in asked.cases)
    assert found.proved
    assert low - 5e-5 * abs(low) < least <= low
    assert high <= most < high + 5e-5 * abs(high)
