"""Means of a study while it runs, and whether they are known well enough to stop.

Runs are counted in the order of their numbers, whatever the order in which they arrive, so that a study stops after the
same run however many threads it has. Means and deviations are Welford's.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from proofmass.graphs.study import Study
from proofmass.runner.engine.planned import PlannedMeasure
from proofmass.runner.studies.intervals import concise, half_of_mean
from proofmass.runner.studies.sensor_runs import SensorRun

FEWEST = 30  # sensors before a study may stop


@dataclass
class _Mean:
    runs: int = 0
    mean: float = 0.0
    squares: float = 0.0

    def add(self, value: float) -> None:
        self.runs += 1
        before = self.mean
        self.mean += (value - before) / self.runs
        self.squares += (value - before) * (value - self.mean)

    def half(self) -> float:
        """Half of the confidence interval."""
        return half_of_mean(self.runs, math.sqrt(self.squares / (self.runs - 1))) if self.runs > 1 else math.inf


class RunningMeans:
    """Means of the measures that `stop` names, or else of the first one, per point of the sweep and epoch."""

    def __init__(self, study: Study, measures: tuple[PlannedMeasure, ...]) -> None:
        self._study = study
        self._watched = [(i, m) for i, m in enumerate(measures) if m.name in study.stop] or [(0, measures[0])]
        epochs = range(len(study.epochs))
        self._means = {
            (point, epoch, i): _Mean() for i, _ in self._watched for point in range(study.points) for epoch in epochs
        }
        self._early: dict[tuple[int, int], SensorRun] = {}  # runs that came before their turn
        self._next = (0, 0)
        self.end = study.runs * study.points  # number of runs that the study needs
        self.enough = False

    def add(self, runs: Iterable[SensorRun]) -> None:
        """Count runs; those after the last one that is needed are left out."""
        for arrived in runs:
            self._early[arrived.run, arrived.epoch] = arrived
            while not self.enough and self._next in self._early:
                self._count(self._early.pop(self._next))

    def text(self) -> str:
        """The mean that is known least, as it is now."""
        if all(mean.runs < 2 for mean in self._means.values()):
            return ""
        name, least = max(
            ((m, self._means[key]) for i, m in self._watched for key in self._means if key[2] == i),
            key=lambda pair: pair[1].half() / (self._study.stop.get(pair[0].name) or 1.0),
        )
        half = least.half()
        unit = f" {name.unit}" if name.unit != "1" else ""
        return f"{name.name} {concise(least.mean, (least.mean - half, least.mean + half))}{unit}"

    def _count(self, run: SensorRun) -> None:
        epochs, points = len(self._study.epochs), self._study.points
        if run.values is not None:
            for i, _ in self._watched:
                if math.isfinite(run.values[i]):
                    self._means[run.run % points, run.epoch, i].add(run.values[i])
        number = run.run + (run.epoch + 1) // epochs
        self._next = number, (run.epoch + 1) % epochs
        sensors, rest = divmod(number, points)
        if self._study.stop and self._next[1] == 0 and rest == 0 and sensors >= FEWEST and self._known():
            self.end, self.enough = number, True
            self._early.clear()

    def _known(self) -> bool:
        """Whether every mean is known as well as it was asked for."""
        return all(
            self._means[key].half() <= self._study.stop[m.name]
            for i, m in self._watched
            for key in self._means
            if key[2] == i
        )
