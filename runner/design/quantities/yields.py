"""Yields of a study whose graph has other parameters: the same sensors are drawn each time."""

from collections.abc import Iterable, Mapping

from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, did_you_mean
from proofmass.graphs.studies.study import Study
from proofmass.runner.studies.outcome.lifetimes import ALL_LIMITS
from proofmass.runner.studies.runs.sensor_runs import SensorRuns
from proofmass.runner.studies.whole.study import run_sensors


class YieldRuns:
    """Runs a study again and again, about other values of its graph."""

    def __init__(self, study: Study | None, limits: Iterable[str]) -> None:
        """Raise `ModelError` where there is no study, or no such limit in it."""
        problems = []
        if study is None or not study.limits:
            hint = "add [study] with spread and limits to the file"
            problems.append(Problem(message="a yield is wanted, and there is no study with limits", hint=hint))
        else:
            for limit in set(limits) - {""} - study.limits.keys():
                hint = did_you_mean(limit, study.limits, "the limits")
                problems.append(Problem(message="the study has no such limit", key="yield", got=limit, hint=hint))
        if problems or study is None:
            raise ModelError([study.graph.placed(problem) if study else problem for problem in problems])
        self.study = study
        self._sensors: dict[tuple[str, ...], SensorRuns] = {}

    def yields(self, values: Mapping[str, float]) -> Mapping[str, float] | None:
        """Return the yield of each limit, and of all by an empty name; None where the graph cannot have the values."""
        names = tuple(values)
        try:
            if names not in self._sensors:
                self._sensors[names] = SensorRuns(self.study.at(values))
            found = run_sensors(self._sensors[names].at(values)).yields()
        except (ModelError, Refusal, ArithmeticError):
            return None
        return {**found, "": found[ALL_LIMITS]} if found else None
