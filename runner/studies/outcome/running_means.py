"""Means of a study while it runs, and whether they are known well enough to stop.

Runs are counted in the order of their numbers, whatever the order in which they arrive, so that a
study stops after the same run however many threads or workers it has. Sums are of differences from
the first value. The groups of Saltelli's design are not independent inside: each counts once, with
its mean.
"""

import math

import numpy as np

from proofmass.graphs.studies.study import Study
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.plan.planned import PlannedMeasure
from proofmass.runner.studies.outcome.intervals import concise, halves_of_means
from proofmass.runner.studies.outcome.outcomes import Outcomes, together

FEWEST = 30  # sensors before a study may stop


class RunningMeans:
    """Means of the measures, those that `stop` names first, per point of the sweep and epoch."""

    def __init__(self, study: Study, measures: tuple[PlannedMeasure, ...]) -> None:
        self._study, self._epochs, self._width = study, len(study.epochs), len(measures)
        self._places = sorted(range(len(measures)), key=lambda place: measures[place].name not in study.stop)
        self._measures = [measures[place] for place in self._places]
        self._asked = np.array([study.stop.get(m.name, math.inf) for m in self._measures])
        shape = study.points, self._epochs, self._width
        self._first = np.full(shape, np.nan)
        self._sums = np.zeros((3, *shape))  # number of values, their sum, the sum of their squares
        self._early = together([], self._epochs, self._width)  # runs that came before their turn
        self._sensors = 0  # counted so far
        self.end = study.runs * study.points  # number of runs that the study needs
        self.enough = False

    def add(self, arrived: Outcomes) -> None:
        """Count runs; those after the last one needed are left out."""
        if self.enough:
            return
        points, group = self._study.points, self._study.designed.group
        waiting = together([self._early, arrived], self._epochs, self._width)
        waiting = waiting.chosen(np.argsort(waiting.numbers, kind="stable"))
        in_turn = waiting.numbers == self._sensors * points * group + np.arange(len(waiting.numbers))
        ready = int(in_turn.sum()) // (points * group) * points * group
        self._early = waiting.chosen(np.arange(ready, len(waiting.numbers)))
        if ready:
            values = waiting.values[:ready, :, self._places].reshape(-1, group, *self._first.shape)
            self._count(values[:, 0] if group == 1 else _means(values))

    def text(self) -> str:
        """Return for each measure the current mean with the widest interval."""
        count, total, _ = self._sums
        if count.max() < 2:
            return ""
        halves, texts = self._halves(self._sums), []
        for place, measure in enumerate(self._measures):
            point, epoch = divmod(int(np.argmax(halves[..., place])), self._epochs)
            at = point, epoch, place
            half = float(halves[at])
            mean = float(self._first[at] + total[at] / count[at]) if count[at] else math.nan
            unit = f" {measure.unit}" if measure.unit != "1" else ""
            texts.append(f"{measure.name} {concise(mean, (mean - half, mean + half))}{unit}")
        return ", ".join(texts)

    def _count(self, values: AnyArray) -> None:
        """Count sensors in their order, to the study's end or until the means are known."""
        sound = np.isfinite(values)
        at_first = np.take_along_axis(values, np.argmax(sound, axis=0)[None], axis=0)[0]
        self._first = np.where(np.isnan(self._first) & sound.any(axis=0), at_first, self._first)
        apart = np.where(sound, values - self._first, 0.0)
        added = np.stack([sound.astype(float), apart, apart * apart], axis=1)
        added[0] += self._sums
        sums = np.cumsum(added, axis=0)
        last = len(values)
        if self._study.stop:
            known = (self._halves(np.moveaxis(sums, 1, 0)) <= self._asked).all(axis=(1, 2, 3))
            known &= self._sensors + 1 + np.arange(last) >= FEWEST
            if known.any():
                last = int(np.argmax(known)) + 1
                self.end, self.enough = (self._sensors + last) * self._study.points * self._study.designed.group, True
        self._sums = sums[last - 1]
        self._sensors += last

    def _halves(self, sums: AnyArray) -> AnyArray:
        """Return half of the confidence interval of each mean; infinite for one value."""
        count, total, squares = sums
        many = np.maximum(count, 2.0)
        variance = np.maximum(squares - total * total / many, 0.0) / (many - 1.0)
        return np.where(count > 1, halves_of_means(many, np.sqrt(variance)), np.inf)


def _means(groups: AnyArray) -> AnyArray:
    """Return the mean of each group over its values that are finite; NaN where none is."""
    sound = np.isfinite(groups)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(sound, groups, 0.0).sum(axis=1) / sound.sum(axis=1))
