"""Sections of a report on lifetimes and calibrations, whole, from fates that were written by hand."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from proofmass.graphs.studies.ages import YEAR
from proofmass.runner.studies.shown import report_lifetimes
from proofmass.runner.studies.shown.report_lifetimes import calibrations_section, lifetimes_section
from tests.by_hand.study_results import AGED, LIMITED, study_result
from tests.runner.studies.shown.test_lifetime_sentences import FATES
from tests.runner.studies.shown.test_report_parts import numbers_of, rows_of

CALIBRATED = 'recalibration = { every = ["never", "1 year"], carried = { "adc.gain_error" = "bias" } }\n'
LAW: Any = SimpleNamespace(
    shape=2.0,
    shape_interval=(1.75, 2.25),
    scale=2.0 * YEAR,
    scale_interval=(1.5 * YEAR, 2.5 * YEAR),
    one_percent=0.5 * YEAR,
    one_percent_interval=(0.25 * YEAR, YEAR),
    survival=lambda ages: np.exp(-((ages / (2.0 * YEAR)) ** 2)),  # 1, 0.779 and 0.105: the last is 0.295 too low
)


@pytest.mark.parametrize(
    ("age", "ends", "oldest", "text"),
    [
        (2.0 * YEAR, (1.9 * YEAR, 2.1 * YEAR), YEAR, "2 years (1.9 to 2.1)"),
        (1800.0, (0.0, 7200.0), math.nextafter(YEAR, 0.0), "0.5 h (0 to 2)"),
        (3600.0 * 1234.0, (3600.0 * 123.4, 3600.0 * 1.2345e7), 7200.0, "1230 h (123 to 1.23e+07)"),
    ],
)
def test_ages_have_three_digits_in_years_or_hours(
    age: float, ends: tuple[float, float], oldest: float, text: str
) -> None:
    assert report_lifetimes._years(age, ends, oldest) == text


def test_a_part_and_its_interval_stay_within_nothing_and_all() -> None:
    assert report_lifetimes._part(0.5, (-0.25, 1.25)) == "50.0 % (0 % to 100 %)"
    assert report_lifetimes._part(0.5, (0.25, 0.75)) == "50.0 % (25.0 % to 75.0 %)"


@pytest.mark.parametrize(("fits", "more"), [(True, ""), (False, " It does not describe them")])
def test_a_limit_that_sensors_leave_is_told_in_words_with_a_table(
    fits: bool, more: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(report_lifetimes, "picture", lambda figure, title: f"<svg>{title}</svg>")
    monkeypatch.setattr(report_lifetimes, "plot_lifetimes", lambda lives: None)
    good, ends = np.array([1.0, 0.9, 0.4]), ((0.96, 1.0), (0.85, 0.95), (0.3, 0.5))
    lives = replace(FATES, law=LAW, band=0.3 if fits else 0.29, good=good, good_intervals=ends)
    text = report_lifetimes._of_limit(lives)
    words = text.partition('</p>\n<div class="wide"><svg>lifetimes of bias</svg></div>')[0]
    expected = (
        "<p>bias: 1 % of the sensors left it between 0 h and 1 year;"
        " 10 % and then 50 % of the sensors left it between 1 year and 3 years."
        " On average a sensor is out of it for 25.0 % of the time (0 % to 30.5 %)."
        " Weibull&#x27;s law has shape 2.00(25) and scale 2 years (1.5 to 2.5);"
        " by it 1 % have left at 0.5 years (0.25 to 1)."
    )
    assert words == expected + (f"{more}: it leaves the band of the survival curve." if more else "")
    assert numbers_of(text) == [0, 1, 2]
    assert rows_of(text) == [
        ["age", "within limits (95 %)", "never out (95 %)"],
        ["0 h", "100 % (96.0 % to 100 %)", "100 % (96.0 % to 100 %)"],
        ["1 year", "90.0 % (85.0 % to 95.0 %)", "95.0 % (89.0 % to 98.0 %)"],
        ["3 years", "40.0 % (30.0 % to 50.0 %)", "40.0 % (30.0 % to 50.0 %)"],
    ]


def test_ages_of_the_law_are_in_years_if_the_oldest_sensor_is_a_year_old(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report_lifetimes, "picture", lambda figure, title: "")
    monkeypatch.setattr(report_lifetimes, "plot_lifetimes", lambda lives: None)
    for oldest, scale in ((1.0, "2 years (1.5 to 2.5)"), (0.75, "17500 h (13100 to 21900)")):
        lives = replace(FATES, law=LAW, ages=(0.0, 0.5 * YEAR, oldest * YEAR))
        assert f"scale {scale};" in report_lifetimes._of_limit(lives)


def test_intervals_between_calibrations_are_compared_by_when_the_first_sensors_leave(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """1 % have left by the first year, 10 % not."""
    monkeypatch.setattr(report_lifetimes, "lifetimes", lambda part: [FATES])
    _, row = rows_of(report_lifetimes._lives_table({"never": study_result(AGED, {"bias": [[1, 2, 3]]})}))
    assert row == ["never", "bias", "40.0 % (30.0 % to 50.0 %)", "between 0 h and 1 year", "25.0 % (0 % to 30.5 %)", ""]


def test_of_many_ages_some_are_in_the_table(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report_lifetimes, "picture", lambda figure, title: "")
    monkeypatch.setattr(report_lifetimes, "plot_lifetimes", lambda lives: None)
    ages, parts, ends = tuple(YEAR * k for k in range(13)), np.linspace(1.0, 0.4, 13), ((0.0, 1.0),) * 13
    lives = replace(FATES, ages=ages, good=parts, good_intervals=ends, surviving=parts, surviving_intervals=ends)
    told = [row[0] for row in rows_of(report_lifetimes._of_limit(lives))[1:]]
    assert told == ["0 h", "2 years", "4 years", "6 years", "8 years", "10 years", "12 years"]


def test_limits_whose_sensors_fare_alike_are_told_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The third fares as the first; the fourth is as good, but does not come back; none leaves the last two."""
    monkeypatch.setattr(report_lifetimes, "_of_limit", lambda lives: f"{lives.limit} told")
    good, kept = FATES.good, np.ones(3)
    fates = [
        replace(FATES, limit="a<"),
        replace(FATES, limit="b", good=good[::-1]),
        replace(FATES, limit="c>"),
        replace(FATES, limit="d", surviving=np.array([1.0, 0.9, 0.3])),
        replace(FATES, limit="e", good=kept, surviving=kept),
        replace(FATES, limit="f", good=kept, surviving=kept),
    ]
    monkeypatch.setattr(report_lifetimes, "lifetimes", lambda result: fates)
    text = lifetimes_section(study_result("", {"bias": [[1.0]]}))
    assert text.splitlines() == ["a< told", "b told", "<p>c&gt;: as a&lt;.</p>", "d told", "e told", "f told"]


@pytest.mark.defect("S840", before="a deviation without a unit had the unit 1", after="none, as in all other tables")
def test_what_calibrations_buy_is_compared_with_the_first_interval() -> None:
    """Without them one sensor of four is within -2 to 3 at last, with them three: two more of four."""
    bias = [[1, 4, 4], [1, 1, 1], [1, 1, 4], [1, 4, 2], [1, 1, 5], [1, 1, 6], [1, 1, 2], [1, 1, 1.5]]
    noise = [[1, 1, 1 + k] for k in range(8)]
    result = study_result(AGED + CALIBRATED + LIMITED, {"bias": bias, "noise": noise}, {"bias": "1", "noise": "V/Hz"})
    text = calibrations_section(result)
    lives, scatter = text.split("\n<div")
    assert numbers_of(lives) == [2, 4, 5]
    heads = ["calibrations", "limit", "within it at 3 years", "1 % have left", "time out of it"]
    head, *rows = rows_of(lives)
    assert head == [*heads, "more than never recalibrated"]
    # out of 3 years: 3, 0, 0, 0 and 0, 2, 0, 0; ends by t of four sensors, 3.1824, and the exact ones of parts
    assert [row[:4] for row in rows] == [
        ["never recalibrated", "bias", "25.0 % (0.6 % to 80.6 %)", "between 0 h and 1 year"],
        ["recalibrated every year", "bias", "75.0 % (19.4 % to 99.4 %)", "between 0 h and 1 year"],
        ["never recalibrated", "noise", "100 % (39.8 % to 100 %)", "not within 3 years"],
        ["recalibrated every year", "noise", "100 % (39.8 % to 100 %)", "not within 3 years"],
        ["never recalibrated", "all limits", "25.0 % (0.6 % to 80.6 %)", "between 0 h and 1 year"],
        ["recalibrated every year", "all limits", "75.0 % (19.4 % to 99.4 %)", "between 0 h and 1 year"],
    ]
    assert [row[4].partition(" (")[0] for row in rows] == ["16.7 %", "16.7 %", "0 %", "0 %", "16.7 %", "16.7 %"]
    gained = "+50.0 % (-41.9 to 141.9 %)"  # 3.1824 * 0.57735 / 2 = 0.9187
    assert [row[5] for row in rows] == ["", gained, "", "+0.0 % (0.0 to 0.0 %)", "", gained]
    head, *rows = rows_of(scatter)
    assert numbers_of(scatter) == [2, 3]
    assert head == ["standard deviation at 3 years", "unit", "never recalibrated", "recalibrated every year"]
    # of 4, 4, 5, 2 and 1, 2, 6, 1.5; of 1, 3, 5, 7 and 2, 4, 6, 8
    assert [[row[0], row[1], *(cell.partition("(")[0] for cell in row[2:])] for row in rows] == [
        ["bias", "", "1.25831", "2.28674"],
        ["noise", "V/Hz", "2.58199", "2.58199"],
    ]


def test_an_interval_without_runs_and_a_single_sensor_are_left_out_of_what_is_compared() -> None:
    result = study_result(AGED + CALIBRATED, {"bias": [[1, 2, 3]] * 2})
    head, row = rows_of(calibrations_section(result))
    assert (head[2:], row) == (["never recalibrated", "recalibrated every year"], ["bias", "", "", ""])
    two = study_result(AGED + CALIBRATED, {"bias": [[1, 2, 3], [1, 2, 4], [1, 2, 5], [1, 2, 7]]})
    assert rows_of(calibrations_section(two))[1][2:] == ["1.41421", "2.12132"]
    one = result.some(result.numbers == 1)
    assert rows_of(calibrations_section(one))[0][2:] == ["recalibrated every year"]
    never = study_result(AGED + CALIBRATED.replace(', "1 year"', ""), {"bias": [[1, 2, 3]] * 2})
    assert calibrations_section(never) == ""
