"""Lifetimes as rows for other tools: yield and survival by age, and what follows from them for each limit."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from proofmass.runner.studies.outcome.lifetimes import OUT, Lifetimes, lifetimes
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.influences import point_columns
from proofmass.runner.studies.shown.points import parts

NEITHER = (math.nan, math.nan)


def yield_rows(result: StudyResult) -> list[dict[str, Any]]:
    """Return a row for each point, limit and age: the parts within the limit, and never out of it, with intervals."""
    return [row for part in parts(result).values() for lives in lifetimes(part) for row in _ages(part, lives)]


def lifetime_rows(result: StudyResult) -> list[dict[str, Any]]:
    """Return a row for each point and limit: ages at which parts have left, Weibull's law, time out of tolerance."""
    return [_whole(part, lives) for part in parts(result).values() for lives in lifetimes(part)]


def _ages(part: StudyResult, lives: Lifetimes) -> Iterator[dict[str, Any]]:
    for place, (epoch, age) in enumerate(zip(lives.epochs, lives.ages, strict=True)):
        good, left = lives.good_intervals[place], lives.surviving_intervals[place]
        yield (
            point_columns(part)
            | {"limit": lives.limit, "epoch": epoch, "age_s": age, "sensors": lives.sensors}
            | {"good": float(lives.good[place]), "good_low": good[0], "good_high": good[1]}
            | {"never_out": float(lives.surviving[place]), "never_out_low": left[0], "never_out_high": left[1]}
            | {"band": lives.band, "weibull": float(lives.law.survival(np.array(age))) if lives.law else math.nan}
        )


def _whole(part: StudyResult, lives: Lifetimes) -> dict[str, Any]:
    row = point_columns(part) | {"limit": lives.limit, "sensors": lives.sensors}
    for share in OUT:
        after, by = lives.left_at(share) or NEITHER
        low, high = lives.left_interval(share)
        named = f"left_{100 * share:g}_percent"
        row |= {f"{named}_after_s": after, f"{named}_by_s": by, f"{named}_low_s": low, f"{named}_high_s": high}
    law, (low, high) = lives.law, lives.time_out_interval
    row |= {"time_out": lives.time_out, "time_out_low": low, "time_out_high": high}
    for name, value, ends in (
        ("shape", law and law.shape, law and law.shape_interval),
        ("scale_s", law and law.scale, law and law.scale_interval),
        ("left_1_percent_s", law and law.one_percent, law and law.one_percent_interval),
    ):
        low, high = ends or NEITHER
        row |= {f"weibull_{name}": value or math.nan, f"weibull_{name}_low": low, f"weibull_{name}_high": high}
    return row | {"weibull_fits": lives.law_fits}
