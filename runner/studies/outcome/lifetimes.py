"""Lifetimes of sensors within their tolerances: yield by age, survival, time out of tolerance.

A sensor is looked at at each epoch. It survives an age if it has kept its limits at every epoch
that counts up to it: survival never rises, though a calibration may bring a sensor back into the
yield. What it was at an epoch counts as time until the next one. Intervals are exact ones of parts
at each age; the band holds at all ages together, S -+ b with b = sqrt(log(2 / (1 - level)) / 2n)
(Massart, Annals of Probability 18 (1990) 1269).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.studies.outcome.intervals import LEVEL, Bounds, part_interval
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.outcome.weibull import Weibull, weibull

ALL_LIMITS = "all limits"
OUT = (0.01, 0.1, 0.5)  # parts of the sensors whose age of leaving is told


@dataclass(frozen=True)
class Lifetimes:
    """Fates of the sensors under one limit, or all; arrays have an entry for each counted age."""

    limit: str
    sensors: int
    epochs: tuple[int, ...]
    ages: tuple[float, ...]  # seconds
    good: AnyArray  # part within its limits at that age
    good_intervals: tuple[Bounds, ...]
    surviving: AnyArray  # part that has never left them
    surviving_intervals: tuple[Bounds, ...]
    good_at_last: AnyArray  # part of each sensor's runs within their limits at the last age
    band: float  # half of the band of the survival curve
    law: Weibull | None  # of the sensors that are good at the first age
    time_out: float  # mean part of the time, from the first age to the last, out of tolerance
    time_out_interval: Bounds

    @property
    def law_fits(self) -> bool:
        """Return whether Weibull's law stays within the band of the survival curve."""
        if self.law is None:
            return False
        return bool(np.abs(self.law.survival(np.array(self.ages)) - self.surviving).max() <= self.band)

    def left_at(self, part: float) -> Bounds | None:
        """Return the ages, in seconds, between which a part of the sensors has left; None if it never does."""
        gone = np.flatnonzero(1.0 - self.surviving >= part - 1e-12)
        if not len(gone):
            return None
        at = int(gone[0])
        return self.ages[at - 1] if at else 0.0, self.ages[at]

    def left_interval(self, part: float) -> Bounds:
        """Return the ages at which the ends of the survival's interval reach 1 - part; infinite where they do not."""
        ends = zip(*self.surviving_intervals, strict=True)
        low, high = (
            next((age for age, end in zip(self.ages, row, strict=True) if end <= 1.0 - part), math.inf) for row in ends
        )
        return low, high


def lifetimes(result: StudyResult) -> Iterator[Lifetimes]:
    """Yield lifetimes of each limit and of all together; none without limits, epochs or runs."""
    study = result.study
    if len(study.epochs) < 2 or not study.limits or not len(result.numbers):
        return
    every = {name: (study.limits[name].counted(study.epochs), result.within(name)) for name in study.limits}
    for name, (first, good) in every.items():
        yield _of(result, name, first, good)
    if len(every) > 1:
        earliest = min(first for first, _ in every.values())
        yield _of(result, ALL_LIMITS, earliest, np.logical_and.reduce([good for _, good in every.values()]))


def _of(result: StudyResult, name: str, first: int, good: AnyArray) -> Lifetimes:
    ages = result.study.epochs[first:]
    good = good[:, first:]
    never_left = np.logical_and.accumulate(good, axis=1)
    sensors, of_sensors = result.sensors, result.of_draws(good)
    alive = result.of_draws(never_left).sum(axis=0)
    edges, left = ages, (-np.diff(alive)).tolist()
    if ages[0] > 0.0:  # a sensor that is bad when new has no lifetime; all others leave after that
        edges, left = (0.0, *ages), [sensors - float(alive[0]), *left]
    spans = np.diff(ages)
    out = (~good[:, :-1] @ spans) / spans.sum() if len(ages) > 1 else np.zeros(len(good))
    return Lifetimes(
        limit=name,
        sensors=sensors,
        epochs=tuple(range(first, first + len(ages))),
        ages=tuple(ages),
        good=of_sensors.mean(axis=0),
        good_intervals=tuple(part_interval(number, sensors) for number in of_sensors.sum(axis=0).tolist()),
        surviving=alive / sensors,
        surviving_intervals=tuple(part_interval(number, sensors) for number in alive.tolist()),
        good_at_last=of_sensors[:, -1],
        band=math.sqrt(math.log(2.0 / (1.0 - LEVEL)) / (2.0 * sensors)),
        law=weibull(edges, left, float(alive[-1])),
        time_out=float(result.of_draws(out).mean()),
        time_out_interval=result.mean_of_sensors(out),
    )
