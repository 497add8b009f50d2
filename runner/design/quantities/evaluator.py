"""Values of several quantities of a graph for given parameters, with derivatives by the free ones.

Loops, noise and transfers are linearised with exact derivatives. Measures come from runs: their
derivatives are differences between runs that lie side by side in lanes and share their noise.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, did_you_mean
from proofmass.graphs.model.adjustable import Adjustable
from proofmass.graphs.model.changes import changed_blocks
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Endpoint, Graph, split
from proofmass.graphs.model.loops import AUTO
from proofmass.graphs.model.quantities import (
    LoopFigure,
    MeasureOf,
    Noise,
    Quantity,
    ResponseFigure,
    TransferPart,
    YieldOf,
)
from proofmass.graphs.studies.study import Study
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.linearisation import At, OperatingPoints
from proofmass.runner.analysis.linearisation.linearise import node_of, one_loop
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.margins.margins import Margins, margins_at, margins_of
from proofmass.runner.analysis.margins.over_phases import OverPhases
from proofmass.runner.analysis.margins.sensitivity import transfer_sensitivities
from proofmass.runner.analysis.margins.stability import AT_ANOTHER_PHASE, open_loop, through_bits
from proofmass.runner.analysis.response.response import refuse_beyond
from proofmass.runner.design.quantities.loop_figures import NoValue, Reading, growth, read_figure, value_of_figure
from proofmass.runner.design.quantities.output_figures import read_noise, read_response
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.measuring import derived_values
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan, varied
from proofmass.runner.run.faults import RunError
from proofmass.runner.run.side_by_side import SideBySide, lane_counts
from proofmass.runner.run.simulate import RunOptions, simulate_plan
from proofmass.runner.studies.draws.drawing import on_arrays
from proofmass.runner.studies.outcome.lifetimes import ALL_LIMITS
from proofmass.runner.studies.runs.sensor_runs import SensorRuns
from proofmass.runner.studies.whole.study import run_sensors

STABLE = "stability of"  # before the name of a loop
QuantityReadings = dict[str, Reading | None]  # None where there is no value
Reasons = Mapping[str, NoValue]  # of those that are None
_Answers = dict[str, Reading | NoValue]
_REFUSED = ModelError, Refusal, ArithmeticError, np.linalg.LinAlgError
_STEP = 1e-3  # of a parameter's width, for differences between runs
_YIELD_STEP = 0.05  # of a parameter's width, over which enough sensors change sides


class Evaluator:
    """Evaluates quantities of one graph again and again; it is planned and compiled once."""

    def __init__(
        self,
        graph: Graph,
        quantities: Mapping[str, Quantity],
        at: str,
        widths: Mapping[str, float],
        study: Study | None = None,
    ) -> None:
        self._adjustable = Adjustable(flatten(graph))
        self.plan = plan(graph.changed(probes=()), free=self._adjustable.following(widths))
        self.quantities, self.at, self.widths = quantities, at, widths
        self.loops = {q.loop: one_loop(self.plan, q.loop)[1] for q in quantities.values() if isinstance(q, LoopFigure)}
        self.measures = {name: q.measure for name, q in quantities.items() if isinstance(q, MeasureOf)}
        self.yields = {name: q.limit for name, q in quantities.items() if isinstance(q, YieldOf)}
        self._study = YieldRuns(study, self.yields.values()) if self.yields else None
        for q in quantities.values():
            if isinstance(q, ResponseFigure) and q.frequency is not None:
                refuse_beyond(self.plan, node_of(self.plan, q.input), node_of(self.plan, q.output), [q.frequency])
        self.evaluations = 0
        self.why: Reasons = {}  # what the latest readings leave out
        self._course = Course(self.plan)  # whose machine code all plans share
        self._ways = dict[str, At]()  # to the operating point of each loop
        self._runs: dict[tuple[str, ...], SideBySide] = {}
        if self.measures:
            self.ticks = self.plan.ticks()

    def readings(self, values: Mapping[str, float], slopes: bool = True) -> QuantityReadings:
        """Return each quantity, and the growth of each loop by `STABLE` and its name, at these parameters."""
        self.evaluations += 1
        found = self._found(values, slopes)
        self.why = {name: of for name, of in found.items() if isinstance(of, NoValue)}
        return {name: None if isinstance(of, NoValue) else of for name, of in found.items()}

    def _found(self, values: Mapping[str, float], slopes: bool) -> _Answers:
        try:
            changed = varied(self.plan, changed_blocks(self.plan.blocks, self._adjustable.settings(values)))
        except _REFUSED as error:
            return dict.fromkeys([*(f"{STABLE} {loop}" for loop in self.loops), *self.quantities], refused(error))
        readings: _Answers = {}
        course = Course(changed, like=self._course)
        points = OperatingPoints(changed, self.at or AUTO, course=course)
        moved = {name: self._adjustable.moved_by(name, values) for name in self.widths} if slopes else {}
        free = self._parameters(changed, moved)
        for loop, node in self.loops.items():
            readings |= self._loop(points, loop, node, free, slopes)
        left = [why for loop in self.loops if (why := _leaves(loop, readings[f"{STABLE} {loop}"]))]
        for name, quantity in self.quantities.items():
            if left and isinstance(
                quantity, Noise | TransferPart | ResponseFigure
            ):  # linear about a point that is left
                readings[name] = left[0]
            elif isinstance(quantity, Noise):
                readings[name] = self._tried(read_noise, points, quantity, free, slopes)
            elif isinstance(quantity, TransferPart):
                readings[name] = self._tried(self._transfer, points, quantity, free)
            elif isinstance(quantity, ResponseFigure):
                readings[name] = self._tried(read_response, points, quantity, free, slopes)
        chained = {name: _chained(reading, moved) for name, reading in readings.items()}
        chained |= self._measured(values, slopes) if self.measures else {}
        return chained | (self._yielded(values, slopes) if self.yields else {})

    @staticmethod
    def _parameters(changed: Plan, moved: Mapping[str, Mapping[str, float]]) -> dict[str, float]:
        """Return all parameters that move with the free numbers, as they are."""
        nodes = {target: split(target) for by_name in moved.values() for target in by_name}
        return {target: float(getattr(changed.blocks[name], entry)) for target, (name, entry) in nodes.items()}

    @staticmethod
    def _tried(read: Callable[..., Reading | NoValue], *given: Any) -> Reading | NoValue:
        try:
            return read(*given)
        except _REFUSED as error:
            return refused(error)

    def _loop(
        self, points: OperatingPoints, loop: str, node: Endpoint, free: Mapping[str, float], slopes: bool
    ) -> _Answers:
        """Return the figures of a loop, those of `margins`; of an unstable one its growth alone."""
        wanted = {n: q.figure for n, q in self.quantities.items() if isinstance(q, LoopFigure) and q.loop == loop}
        stable = f"{STABLE} {loop}"
        try:
            point = self._at_its_point(loop, points)
            system = open_loop(point, node, by_parameters=slopes)
            margins = margins_of(system, loop, ".".join(node))
            grown = growth(system, list(free) if slopes else [])
            if not margins.stable:
                unstable = NoValue(f"the loop {loop} is {margins.verdict}", unstable=True)
                return dict.fromkeys(wanted, unstable) | {stable: grown._replace(value=abs(grown.value))}
            figures = _FiguresOfLoop(point, node, system, margins, free if slopes else {})
            readings = {name: figures.reading(figure) for name, figure in wanted.items()}
            return {**readings, stable: grown._replace(value=-abs(grown.value))}
        except _REFUSED as error:
            return dict.fromkeys([stable, *wanted], refused(error))

    def _at_its_point(self, loop: str, points: OperatingPoints) -> OperatingPoints:
        """Return the operating point of a loop, found as at first: figures stay smooth."""
        if self.at:
            return points
        if loop not in self._ways:
            node = self.loops[loop]
            self._ways[loop] = points.about_loop(node, otherwise=through_bits(points.plan, node))[0].at
        return OperatingPoints(points.plan, self._ways[loop], course=points.course)

    def _transfer(self, points: OperatingPoints, wanted: TransferPart, free: Mapping[str, float]) -> Reading:
        nodes = node_of(points.plan, wanted.input), node_of(points.plan, wanted.output)
        both = points.answered(lambda about: transfer_sensitivities(about, *nodes))
        found = both[wanted.part == "bias"]
        slopes = {effect.parameter: effect.derivative for effect in found.effects}
        return Reading(found.value, {name: slopes.get(name, 0.0) for name in free})

    def _measured(self, values: Mapping[str, float], slopes: bool) -> _Answers:
        """Return the measures, and their differences between runs side by side."""
        steps = {name: _STEP * width for name, width in self.widths.items()} if slopes else {}
        table, why = self._measure(_beside(values, steps))
        order = {name: column for column, name in enumerate(self.measured_names)}
        readings: _Answers = {}
        for goal, measure in self.measures.items():
            column = table[:, order[measure]]
            sides = column[1:].reshape(-1, 2)
            moved = (sides[:, 0] - sides[:, 1]) / (2.0 * np.array([*steps.values()]))
            known = dict(zip(steps, np.nan_to_num(moved).tolist(), strict=True))
            none = NoValue(why.get(0, f"the run has no value of {measure}"))
            readings[goal] = Reading(float(column[0]), known) if math.isfinite(column[0]) else none
        return readings

    def measure(self, rows: Sequence[Mapping[str, float]]) -> Array:
        """Return the measures of runs with these parameters, a row for each; NaN if one failed."""
        return self._measure(rows)[0]

    def _measure(self, rows: Sequence[Mapping[str, float]]) -> tuple[Array, dict[int, str]]:
        """Return the measures, and why runs failed, by their number."""
        rows = [self._adjustable.settings(row) for row in rows]
        names = tuple(rows[0])
        if names not in self._runs:
            counts = lane_counts()
            lanes = min((n for n in counts if n >= len(rows)), default=counts[0])
            self._runs[names] = SideBySide(self.plan, self.plan.graph.seed, self.ticks, lanes, names)
        given = {name: np.array([row[name] for row in rows]) for name in names}
        measured, sound = self._runs[names].measured(given, np.zeros(len(rows), dtype=np.int64))
        why = dict[int, str]()
        for number in np.flatnonzero(~sound).tolist():  # lanes cannot take it, or it fails
            try:
                changed = varied(self.plan, changed_blocks(self.plan.blocks, rows[number]))
                alone = simulate_plan(changed, self.plan.graph.root, RunOptions()).measures
                measured[number] = [alone[measure.name].value for measure in self.plan.measures]
            except (*_REFUSED, RunError) as error:
                measured[number], why[number] = np.nan, refused(error).reason
        columns = dict(zip(self.measured_names, measured.T, strict=False))
        return np.column_stack([measured, *derived_values(self.plan, columns, on_arrays)]), why

    @property
    def measured_names(self) -> list[str]:
        """Names of the measures in the order of the columns of `measure`: those of signals, then formulas of them."""
        return [measure.name for measure in self.plan.measures] + [formula.name for formula in self.plan.derived]

    def _yielded(self, values: Mapping[str, float], slopes: bool) -> _Answers:
        """Return the yields; their derivatives are differences over a part of the widths, with the same sensors."""
        assert self._study is not None
        steps = {name: _YIELD_STEP * width for name, width in self.widths.items()} if slopes else {}
        now, *beside = [self._study.yields(row) for row in _beside(values, steps)]
        if isinstance(now, NoValue):
            return dict.fromkeys(self.yields, now)
        readings: _Answers = {}
        for goal, limit in self.yields.items():
            sides = [now[limit] if isinstance(row, NoValue) else row[limit] for row in beside]
            pairs = zip(steps.items(), sides[::2], sides[1::2], strict=True)
            readings[goal] = Reading(now[limit], {n: (up - down) / (2.0 * step) for (n, step), up, down in pairs})
        return readings


def refused(error: Exception) -> NoValue:
    """Return why there is no value: what an error says, without its place."""
    if isinstance(error, RunError):
        return NoValue(f"{error.problem.key} {error.problem.message}")
    problems = error.problems if isinstance(error, ModelError) else ()
    return NoValue("; ".join(f"{p.message}: {p.got}" if p.got else p.message for p in problems) or str(error))


def _beside(values: Mapping[str, float], steps: Mapping[str, float]) -> list[dict[str, float]]:
    """Return values, then those with each step up and down."""
    sides = ((name, side * step) for name, step in steps.items() for side in (1.0, -1.0))
    return [dict(values), *({**values, name: values[name] + step} for name, step in sides)]


def _leaves(loop: str, grown: Reading | NoValue) -> NoValue | None:
    """Return why a loop does not stay at its operating point; None where it does."""
    if isinstance(grown, NoValue):
        return grown
    return None if grown.value < 0.0 else NoValue(f"the loop {loop} is not stable", unstable=True)


def _chained(reading: Reading | NoValue, moved: Mapping[str, Mapping[str, float]]) -> Reading | NoValue:
    """Return a reading with derivatives by the free numbers, from those by the parameters that move with them."""
    if isinstance(reading, NoValue):
        return reading
    pairs = {name: [(by, reading.slopes.get(target, 0.0)) for target, by in of.items()] for name, of in moved.items()}
    return Reading(reading.value, {name: sum(by * slope for by, slope in terms) for name, terms in pairs.items()})


class _FiguresOfLoop:
    """Figures of a stable loop at the worst instant ahead and the worst phase of what oscillates.

    Derivatives are those at that phase; of instants ahead they are those of now.
    """

    def __init__(
        self, point: OperatingPoints, node: Endpoint, now: OpenLoop, margins: Margins, free: Mapping[str, float]
    ) -> None:
        self._node, self._free, self._now, self._phases = node, free, now, OverPhases(point)
        self._found = self._phases.noted(margins, node)

    def reading(self, figure: str) -> Reading | NoValue:
        """Return a figure, and its derivatives by the free parameters."""
        own = value_of_figure(self._found, figure)
        least = self._found.elsewhere.get(figure, own)
        if self._found.elsewhere.get("gain_margin") == -math.inf:
            return NoValue(f"the loop {self._found.loop} is unstable {AT_ANOTHER_PHASE}", unstable=True)
        if figure == "bandwidth" and math.isinf(own) and math.isinf(value_of_figure(self._found, "overshoot")):
            return NoValue(f"the loop {self._found.loop} passes nothing at rest, and has no bandwidth")
        if not self._free:
            return Reading(least, {})
        system = (self._phases.at_worst(self._node, figure) if least != own else None) or self._now
        at_one = self._found if least == own and not system.map.others else margins_at(system, "", "")
        return Reading(least, read_figure(at_one, system, figure, self._free).slopes)


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

    def yields(self, values: Mapping[str, float]) -> Mapping[str, float] | NoValue:
        """Return the yield of each limit, and of all by an empty name; or why the graph cannot have the values."""
        names = tuple(values)
        try:
            if names not in self._sensors:
                self._sensors[names] = SensorRuns(self.study.at(values))
            found = run_sensors(self._sensors[names].at(values)).yields()
        except _REFUSED as error:
            return refused(error)
        return {**found, "": found[ALL_LIMITS]} if found else NoValue("no sensor of the study has a run")
