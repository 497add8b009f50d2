"""Sentences on lifetimes of sensors, of fates written by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from proofmass.graphs.studies.ages import YEAR
from proofmass.runner.studies.outcome.lifetimes import Lifetimes
from proofmass.runner.studies.shown.report_lifetimes import _left_sentence, _never_text, _time_out_sentence, left_text

FATES = Lifetimes(
    limit="bias",
    sensors=100,
    epochs=(0, 1, 2),
    ages=(0.0, YEAR, 3.0 * YEAR),
    good=np.array([1.0, 0.95, 0.4]),
    good_intervals=((0.96, 1.0), (0.89, 0.98), (0.3, 0.5)),
    surviving=np.array([1.0, 0.95, 0.4]),
    surviving_intervals=((0.96, 1.0), (0.89, 0.98), (0.3, 0.5)),
    good_at_last=np.arange(100) < 40,
    band=0.136,
    law=None,
    time_out=0.25,
    time_out_interval=(-0.01, 0.305),
)


def surviving(*parts: float) -> Lifetimes:
    return replace(FATES, surviving=np.array(parts))


@pytest.mark.parametrize(
    ("parts", "part", "text"),
    [
        ((1.0, 0.95, 0.4), 0.05, "between 0 h and 1 year"),
        ((1.0, 0.95, 0.4), 0.06, "between 1 year and 3 years"),
        ((1.0, 0.95, 0.4), 0.61, "not within 3 years"),
        ((0.5, 0.5, 0.4), 0.5, "when new"),
    ],
)
def test_the_ages_between_which_a_part_has_left_are_told(parts: tuple[float, ...], part: float, text: str) -> None:
    assert left_text(surviving(*parts), part) == text


@pytest.mark.parametrize(
    ("parts", "text"),
    [
        (
            (1.0, 0.95, 0.4),
            "1 % of the sensors left it between 0 h and 1 year; "
            "10 % and then 50 % of the sensors left it between 1 year and 3 years.",
        ),
        (
            (0.95, 0.95, 0.95),
            "1 % of the sensors were out of it when new; fewer than 10 % had left it at 3 years.",
        ),
        ((1.0, 1.0, 0.995), "fewer than 1 % had left it at 3 years."),
    ],
)
def test_parts_that_left_in_one_span_are_told_together(parts: tuple[float, ...], text: str) -> None:
    assert _left_sentence(surviving(*parts)) == text


def test_the_time_out_of_tolerance_is_never_less_than_nothing() -> None:
    assert _time_out_sentence(FATES) == " On average a sensor is out of it for 25.0 % of the time (0 % to 30.5 %)."
    assert _time_out_sentence(replace(FATES, time_out=0.0)) == ""


def test_a_limit_that_all_sensors_keep_is_told_with_the_low_end_of_the_last_age() -> None:
    text = "bias: no sensor left it within 3 years; with 95 % confidence at least 30.0 % of all such sensors keep it."
    assert _never_text(FATES) == text


def test_the_ages_of_an_interval_are_the_first_at_which_its_ends_have_fallen() -> None:
    assert FATES.left_interval(0.1) == (YEAR, 3.0 * YEAR)
    assert FATES.left_interval(0.6) == (3.0 * YEAR, math.inf)
    assert FATES.left_interval(0.5) == (3.0 * YEAR, 3.0 * YEAR)
    assert not FATES.law_fits
