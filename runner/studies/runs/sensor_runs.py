"""The runs of a study: run k is a pure function of (graph, study, seed, k).

The graph is planned and compiled once, without probes. A run passes its own numbers to the loop. Engine,
runs side by side with it and their order change no bit of it.
"""

import copy
import dataclasses
import math
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self, TypeVar

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.blocks.language.once import text_of_once
from proofmass.graphs.formulas.tree import plainly
from proofmass.graphs.studies.study import AFTER_CALIBRATION, Study
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.plan.measuring import derived_values, planned_derived, refuse_late, value_of
from proofmass.runner.plan.memory import Memory, start
from proofmass.runner.plan.planned import Plan, PlannedMeasure
from proofmass.runner.planning.plan import plan, varied
from proofmass.runner.program.tick_loop import bytes_of_a_run
from proofmass.runner.reference.interpret import TickError
from proofmass.runner.run.beginning import code_of
from proofmass.runner.run.engine_table import ENGINES, EngineName, Starter, engine_problems
from proofmass.runner.run.engines import choose
from proofmass.runner.run.faults import failed, name_fault
from proofmass.runner.run.side_by_side import SideBySide, lanes_for, whole_lanes
from proofmass.runner.studies.draws.drawing import drawn_together, on_arrays
from proofmass.runner.studies.outcome.outcomes import Outcomes, SensorRun, outcomes_of
from proofmass.runner.studies.runs.margins_per_run import margin_measures

_Answer = TypeVar("_Answer")
Values = tuple[float, ...]
if TYPE_CHECKING:
    from proofmass.runner.analysis.margins.many import ManyMargins

CHUNK = 1 << 18  # ticks between looks at Ctrl-C
PART = 1 << 24  # ticks of all runs that are handed to a thread together
PART_BYTES = 1 << 25  # of memory, at most, that these runs take


class SensorRuns:
    """Computes runs of a study."""

    def __init__(self, study: Study, engine: EngineName = "auto", lanes: int | None = None) -> None:
        problems = engine_problems(engine, studies=True)
        if problems:
            raise ModelError(problems)
        self.study = study
        self.plan = plan(study.graph.changed(probes=()), free=study.varying)
        margins = margin_measures(self.plan, study.margins)
        self.own_measures = (*self.plan.measures, *margins, *planned_derived(self.plan))
        self.measures = (*self.own_measures, *change_measures(study, self.own_measures))
        self.ticks = self.plan.ticks()
        refuse_late(self.plan, self.ticks)
        self._total = self.ticks * study.runs * study.points * len(study.epochs)
        self.engine: EngineName = choose(self.plan, self._total, engine)
        runs = study.runs * study.points
        wanted = lanes_for(runs, bytes_of_a_run(self.plan)) if lanes is None else whole_lanes(lanes)
        self.lanes = wanted if ENGINES[self.engine].lanes else 0
        self.together = self._side_by_side() if self.lanes else None

    def at(self, values: Mapping[str, float]) -> Self:
        """Return the runs about other values of parameters that the study sweeps; nothing is compiled again."""
        other = copy.copy(self)
        other.study = self.study.at(values)
        return other

    @cached_property
    def _margins(self) -> "ManyMargins":
        # start-up time: only studies with margins need them
        from proofmass.runner.analysis.margins.many import ManyMargins

        return ManyMargins(self.plan, self.study.margins)

    def margins_of(self, sensors: Sequence[Plan]) -> Sequence[Values | ModelError]:
        """Return the margins of each sensor in the order of their measures, or why it has none."""
        return self._margins.values(sensors) if self.study.margins else [()] * len(sensors)

    def _side_by_side(self) -> SideBySide:
        return SideBySide(self.plan, self.study.seed, self.ticks, self.lanes, sorted(self.study.varying))

    @cached_property
    def _unset(self) -> dict[str, float]:
        """Return the values of calibrated parameters before the first calibration."""
        return {name: self.study.nominal(name) for name in self.study.recalibration.carried}

    def code(self) -> str:
        """Return a hash of what blocks compute in the sensor as it is, and of what others begin with."""
        kinds = {type(block) for block in self.plan.blocks.values()}
        once = "\n".join(sorted(filter(None, map(text_of_once, kinds))))
        with suppress(ModelError):  # a run whose parameters leave their bounds fails, and begins with nothing
            return code_of(self.plan, varied(self.plan, self.study.blocks(self.study.drawn(0)[-1])), once=once)
        return code_of(self.plan, once=once)

    def parts(self, numbers: AnyArray, threads: int) -> Iterator[AnyArray]:
        """Yield runs in parts for `runs`: large enough to hide the cost of a part, equally many for each thread."""
        size = 1
        if self.together is not None:
            epochs, groups = len(self.study.epochs), -(-len(numbers) // self.lanes)
            largest = min(
                PART // (self.ticks * self.lanes * epochs), PART_BYTES // (self.together.compiled.size * epochs)
            )
            parts = threads * -(-groups // (threads * max(1, largest)))
            size = self.lanes * max(1, -(-groups // max(1, parts)))
        for first in range(0, len(numbers), size):
            yield numbers[first : first + size]

    def runs(self, numbers: Sequence[int] | AnyArray, stop: threading.Event) -> Outcomes:
        """Return the outcomes of runs at all epochs, side by side if the engine has lanes.

        Side by side, raises `StoppedError` soon after the event is set.
        """
        epochs = len(self.study.epochs)
        which = np.array(numbers, dtype=np.int64)
        if self.together is None:
            return self._one_by_one(which)
        drawn = drawn_together(self.study, which)
        outcomes, after = self._nothing(which), self._nothing(which)
        left = {name: np.full(len(which), value) for name, value in self._unset.items()}
        intervals = len(self.study.recalibration.every)
        calibrated = np.array([self.study.calibrated(number) for number in range(intervals)])[which % intervals]
        calibrations = np.zeros((len(which), epochs), dtype=bool)
        for some in [slice(e, e + 1) for e in range(epochs)] if left else [slice(None)]:
            values = {name: rows[some] for name, rows in drawn.items()}
            values |= {name: now[None] for name, now in left.items()}
            self._abreast(outcomes, range(epochs)[some], self.study.settings(values, on_arrays), stop)
            if left:
                calibrations[:, some.start] = self._carry(outcomes, some.start, calibrated[:, some.start], left)
                if self.study.followed and calibrations[:, some.start].any():
                    values |= {name: now[None] for name, now in left.items()}
                    self._follow(after, some.start, calibrations[:, some.start], values, stop)
        return self._with_changes(outcomes, calibrations, after.values)

    def _one_by_one(self, numbers: AnyArray) -> Outcomes:
        every = [self._followed(number) for number in numbers.tolist()]
        epochs, measures = len(self.study.epochs), len(self.own_measures)
        outcomes = outcomes_of((run for runs, _ in every for run in runs), epochs, measures)
        after = np.array([rows for _, rows in every]).reshape(len(every), epochs, -1)
        calibrated = np.array([self.study.calibrated(number) for number in numbers.tolist()], dtype=bool)
        done = calibrated & np.isfinite(outcomes.values[:, :, self._carried]).all(axis=2)
        return self._with_changes(outcomes, done, after)

    def _nothing(self, numbers: AnyArray) -> Outcomes:
        shape = len(numbers), len(self.study.epochs), len(self.own_measures)
        return Outcomes(numbers, np.full(shape, np.nan), {})

    def _with_changes(self, outcomes: Outcomes, calibrated: AnyArray, after: AnyArray) -> Outcomes:
        """Return the outcomes with the changes of measures, `after` those of the runs that follow calibrations."""
        if not self.study.changes:
            return outcomes
        names = [measure.name for measure in self.own_measures]
        changed = change_values(self.study, names, outcomes.values, calibrated, after)
        return outcomes._replace(values=np.concatenate([outcomes.values, changed], axis=2))

    def _follow(
        self, after: Outcomes, epoch: int, which: AnyArray, values: Mapping[str, AnyArray], stop: threading.Event
    ) -> None:
        """Run again, with what they have just left and noise of its own, the sensors that were calibrated."""
        chosen = {name: np.broadcast_to(rows, (1, len(which)))[:, which] for name, rows in values.items()}
        some = self._nothing(after.numbers[which])
        self._abreast(some, [epoch], self.study.settings(chosen, on_arrays), stop, AFTER_CALIBRATION)
        after.values[which, epoch] = some.values[:, epoch]

    def _carry(self, outcomes: Outcomes, epoch: int, calibrated: AnyArray, left: dict[str, AnyArray]) -> AnyArray:
        """Store results of calibrations as parameters of later epochs; return those done."""
        measured = outcomes.values[:, epoch, self._carried]
        new = calibrated & np.isfinite(measured).all(axis=1)
        for name, values in zip(self.study.recalibration.carried, measured.T, strict=True):
            left[name] = np.where(new, values, left[name])
        return np.asarray(new)

    @cached_property
    def _carried(self) -> list[int]:
        """Places of the measures that calibrations store, in the order of the parameters."""
        names = [measure.name for measure in self.own_measures]
        return [names.index(measure) for measure in self.study.recalibration.carried.values()]

    def run(self, number: int) -> list[SensorRun]:
        """Return one run at each epoch, without changes; results of calibrations become parameters of later epochs."""
        return self._followed(number)[0]

    def _followed(self, number: int) -> tuple[list[SensorRun], list[tuple[float, ...]]]:
        """Return a run at each epoch, and the measures after each calibration; NaN elsewhere."""
        runs, left = list[SensorRun](), dict[str, float]()
        unknown = (math.nan,) * len(self.own_measures)
        after = [unknown] * len(self.study.epochs)
        calibrated = self.study.calibrated(number)
        for epoch, values in enumerate(self.study.drawn(number)):
            runs.append(self._alone(number, epoch, values | left))
            if calibrated[epoch]:
                left |= self._left_by(runs[-1])
                if self.study.followed:
                    after[epoch] = self._alone(number, epoch, values | left, AFTER_CALIBRATION).values or unknown
        return runs, after

    def parameters(self, number: int, epoch: int) -> dict[str, float]:
        """Return the parameters of a run at an epoch; the calibrations before it are run for their results."""
        drawn, left = self.study.drawn(number), dict[str, float]()
        for before, calibrated in enumerate(self.study.calibrated(number)[:epoch]):
            if calibrated:
                left |= self._left_by(self._alone(number, before, drawn[before] | left))
        return drawn[epoch] | left

    def _left_by(self, run: SensorRun) -> dict[str, float]:
        """Return the parameters that a calibration sets; none if it failed, or one of its measures has no value."""
        measured = [run.values[place] for place in self._carried] if run.values else [math.nan]
        whole = all(map(math.isfinite, measured))
        return dict(zip(self.study.recalibration.carried, measured, strict=True)) if whole else {}

    def _abreast(
        self,
        outcomes: Outcomes,
        epochs: Sequence[int],
        values: Mapping[str, AnyArray],
        stop: threading.Event,
        noise_from: int = 0,
    ) -> None:
        """Run sensors at some epochs side by side, with parameters for each epoch and run."""
        assert self.together is not None
        shape = len(epochs), len(outcomes.numbers)
        noise = noise_from + np.array([noise_run(self.study, outcomes.numbers, epoch) for epoch in epochs]).ravel()
        flat = {name: np.broadcast_to(rows, shape).ravel() for name, rows in values.items()}
        measured, sound = self.together.measured(flat, noise, stop)
        of_run = outcomes.values[:, epochs[0] : epochs[-1] + 1]
        of_run[..., : measured.shape[1]] = np.moveaxis(measured.reshape(*shape, -1), 0, 1)
        if self.plan.derived:
            columns = [of_run[..., column] for column in range(measured.shape[1])]
            of_run[..., -len(self.plan.derived) :] = np.stack(self._derived(columns, on_arrays), axis=-1)
        places = [*range(len(noise))] if self.study.margins else np.flatnonzero(~sound).tolist()
        sensors = [self._sensor({name: float(each[place]) for name, each in flat.items()}) for place in places]
        plans = [sensor for sensor in sensors if isinstance(sensor, Plan)]
        margins = iter(self.margins_of(plans))
        for place, sensor in zip(places, sensors, strict=True):
            at, run = divmod(place, shape[1])
            known = tuple(measured[place].tolist()) if sound[place] else None
            own = next(margins) if isinstance(sensor, Plan) else ()
            done = self._at(int(outcomes.numbers[run]), epochs[at], sensor, own, known, noise_from)
            of_run[run, at] = np.nan if done.values is None else done.values
            if done.fault:
                outcomes.faults[done.run, done.epoch] = done.fault

    def _sensor(self, values: dict[str, float]) -> Plan | ModelError:
        """Return the plan of a sensor, or why there is none."""
        try:
            return varied(self.plan, self.study.blocks(values))
        except ModelError as error:
            return error

    def _at(
        self,
        number: int,
        epoch: int,
        sensor: Plan | ModelError,
        margins: Values | ModelError,
        measured: tuple[float, ...] | None = None,
        noise: int = 0,
    ) -> SensorRun:
        """Return one run at one epoch, whose signals may have been measured already."""
        try:
            sensor = _sound(sensor)
            if measured is None:
                memory = self._last(sensor, noise + noise_run(self.study, number, epoch))
                measured = tuple(value_of(sensor, measure, memory) for measure in self.plan.measures)
            return SensorRun(number, epoch, (*measured, *_sound(margins), *self._derived(measured)))
        except ModelError as error:
            return SensorRun(number, epoch, None, _said(error.problems[0]))
        except TickError as fault:
            assert isinstance(sensor, Plan)
            return SensorRun(number, epoch, None, _said(failed(sensor, fault)))

    def _alone(self, number: int, epoch: int, values: dict[str, float], noise: int = 0) -> SensorRun:
        """Return one run at one epoch."""
        sensor = self._sensor(values)
        (margins,) = self.margins_of([sensor]) if isinstance(sensor, Plan) else ((),)
        return self._at(number, epoch, sensor, margins, noise=noise)

    def _derived(self, measured: Sequence[Any], apply: Callable[[str, list[Any]], Any] = plainly) -> tuple[Any, ...]:
        """Return the measures that follow from others, whose numbers or columns are given."""
        by_name = {measure.name: value for measure, value in zip(self.plan.measures, measured, strict=True)}
        return derived_values(self.plan, by_name, apply)

    def _last(self, changed: Plan, run: int) -> Memory:
        engine = self._starter(changed, self.study.seed, run, start(changed))
        for first in range(0, self.ticks, CHUNK):
            before, last = engine.snapshot(), min(first + CHUNK, self.ticks)
            if not engine.advance(last, ()):
                name_fault(changed, self.study.seed, run, before(), last)
        return engine.memory()

    @cached_property
    def _starter(self) -> Starter:
        """Starts one run; not needed while all runs go side by side."""
        return ENGINES[self.engine].prepare(self.plan, self._total)


def _said(problem: Problem) -> str:
    """Return why a run failed, without the file of the study: the same words on every machine."""
    return str(dataclasses.replace(problem, file="", line=0))


def noise_run(study: Study, run: Any, epoch: int) -> Any:
    """Return the number that makes noise of a run and epoch unique; peers of a design share it."""
    return study.peer(run) * len(study.epochs) + epoch


def _sound(answer: _Answer | ModelError) -> _Answer:
    if isinstance(answer, ModelError):
        raise answer
    return answer


def change_measures(study: Study, measures: tuple[PlannedMeasure, ...]) -> tuple[PlannedMeasure, ...]:
    """Return changes of measures a study asks for, as measures nothing reads in the loop."""
    units = {measure.name: (measure.unit, measure.shown_in) for measure in measures}
    found = []
    for name, change in study.changes.items():
        unit, shown_in = ("1", "") if change.relative else units[change.measure]
        found.append(PlannedMeasure(name, change.measure, change.text, unit, ("", ""), False, 0, shown_in))
    return tuple(found)


def change_values(study: Study, names: list[str], values: AnyArray, calibrated: AnyArray, after: AnyArray) -> AnyArray:
    """Return the changes of runs at all epochs, in the order of the study.

    `values` are by run, epoch and measure of `names`; `after` those of the runs that follow the
    calibrations, where `calibrated`, by run and epoch, says that one took place.
    """
    changed = np.empty((*values.shape[:2], len(study.changes)))
    for place, change in enumerate(study.changes.values()):
        column = names.index(change.measure)
        now = values[:, :, column]
        reference = np.repeat(now[:, change.reference(study.epochs)][:, None], now.shape[1], axis=1)
        if change.since_calibration:
            for epoch in range(1, now.shape[1]):
                before = slice(None), epoch - 1
                reference[:, epoch] = np.where(calibrated[before], after[(*before, column)], reference[before])
        with np.errstate(all="ignore"):
            changed[..., place] = (now - reference) / reference if change.relative else now - reference
    return changed
