"""Requirements of a graph against its run, loops and study; each is computed only where something asks for it."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.checks.requirements import PROVABLE, StabilityVerdict, asked, quantity_of
from proofmass.graphs.model.flatten import FlatGraph
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.loops import AUTO, MARGIN_MEASURES, VERDICTS
from proofmass.graphs.model.quantities import (
    LoopFigure,
    MeasureOf,
    Noise,
    Quantity,
    ResponseFigure,
    TransferPart,
    YieldOf,
)
from proofmass.graphs.model.requirements import SPREAD, TABLE, Requirement
from proofmass.graphs.studies.study import Study
from proofmass.runner.analysis.margins.stability import AT_ANOTHER_PHASE
from proofmass.runner.design.proof.attempt import MarginProof
from proofmass.runner.design.proof.prove import prove, prove_margin
from proofmass.runner.design.quantities.evaluator import Evaluator, refused
from proofmass.runner.design.worst.worst import worst_of
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.faults import RunError
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import simulate
from proofmass.runner.studies.outcome.lifetimes import ALL_LIMITS
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.runs.margins_per_run import margin_measures, margins_at
from proofmass.runner.studies.whole.study import run_study

_IT = "required"
NO_VARIANTS: Mapping[str, Study] = MappingProxyType({})
_SAMPLES = 30  # random points of a worst case; `proofmass worst` tries as many as one likes


@dataclass(frozen=True)
class Finding:
    """A requirement and what was found; `value` is NaN where there is none."""

    id: str
    text: str
    quantity: str
    unit: str
    value: float
    at_least: float
    at_most: float
    reason: str = ""  # why there is no value, or which sensor has it

    @property
    def met(self) -> bool:
        """Return whether the value keeps both limits; none keeps nothing."""
        return self.at_least <= self.value <= self.at_most

    @property
    def room(self) -> float:
        """Return how far the value lies within the limits; negative beyond one, or without a value."""
        room = min(self.value - self.at_least, self.at_most - self.value)
        return -math.inf if math.isnan(room) else room

    def as_data(self) -> dict[str, Any]:
        """Return the finding as plain data, None for values that are not finite."""
        data = {key: _finite(value) for key, value in asdict(self).items()}
        return data | {"met": self.met}


class Measurements:
    """The quantities of a graph and its study, computed when they are first asked for.

    `variants` are the others of the study by name: what is asked of the study is asked of them too.
    """

    def __init__(
        self,
        graph: Graph,
        study: Study | None,
        engine: EngineName = "auto",
        runs: int | None = None,
        variants: Mapping[str, Study] = NO_VARIANTS,
    ) -> None:
        self.graph, self.study, self.runs = graph, study, runs
        self.variants = {name: Measurements(each.graph, each, engine, runs) for name, each in variants.items()}
        self.engine: EngineName = engine
        self._margins: dict[str, Mapping[str, float]] = {}

    @property
    def run(self) -> Result:
        """The run of the graph; raises `RunError` where it fails."""
        if isinstance(self._run, RunError):
            raise self._run
        return self._run

    @cached_property
    def _run(self) -> Result | RunError:
        """The run, or why it failed: a late failure is not tried again for the next."""
        try:
            return simulate(self.graph.changed(probes=()), engine=self.engine)
        except RunError as error:
            return error

    @cached_property
    def result(self) -> StudyResult:
        """The study; raises `ModelError` where the graph has none."""
        return run_study(self._needed_study("a yield"), runs=self.runs, engine=self.engine)

    def margins(self, at: str) -> Mapping[str, float]:
        """Return the margins of all loops at an operating point, as `main.phase_margin`."""
        at = at or AUTO
        if at not in self._margins:
            planned = plan(self.graph)
            names = [measure.name for measure in margin_measures(planned, at)]
            self._margins[at] = dict(zip(names, margins_at(planned, at), strict=True))
        return self._margins[at]

    def values(self, requirement: Requirement) -> list[tuple[float, str]]:
        """Return the value of the quantity, or the worst ones on the sides of its limits, NaN with its reason.

        Raises `ModelError`.
        """
        quantity = quantity_of(self.flat, requirement)
        if requirement.tolerances and not isinstance(quantity, StabilityVerdict):
            return self._worst(requirement, quantity)
        return [self._value(requirement, quantity)]

    def _value(self, requirement: Requirement, quantity: Quantity | StabilityVerdict) -> tuple[float, str]:
        if isinstance(quantity, MeasureOf):
            value = self.run.measures[quantity.measure].value
            return value, f"the run has no value of {quantity.measure}" * math.isnan(value)
        if isinstance(quantity, YieldOf):
            return self._yield(quantity), ""
        if isinstance(quantity, StabilityVerdict):
            return self.margins(requirement.at)[f"{quantity.loop}.stable"], ""
        if isinstance(quantity, LoopFigure) and quantity.loop in self.flat.loops and quantity.figure in MARGIN_MEASURES:
            return self._margin(quantity, self.margins(requirement.at))
        evaluator = Evaluator(self.graph, {_IT: quantity}, requirement.at, {})
        reading = evaluator.readings({}, slopes=False)[_IT]
        return (math.nan, evaluator.why[_IT].reason) if reading is None else (reading.value, "")

    @staticmethod
    def _margin(of: LoopFigure, known: Mapping[str, float]) -> tuple[float, str]:
        value, verdict = known[f"{of.loop}.{of.figure}"], known[f"{of.loop}.stable"]
        beyond = known[f"{of.loop}.gain_margin"] == -math.inf
        if not (beyond or math.isnan(value)):
            return value, ""
        words = {number: word for word, number in VERDICTS.items()}
        told = f"unstable {AT_ANOTHER_PHASE}" if beyond else words[verdict]
        return math.nan, f"the loop {of.loop} is {told}"

    def _worst(self, requirement: Requirement, quantity: Quantity) -> list[tuple[float, str]]:
        """Return the worst values within tolerances; NaN where a loop is unstable or runs fail."""
        tolerances = _tolerances(requirement)
        source: Graph | Study = self.graph
        if not tolerances or isinstance(quantity, YieldOf):
            source = self._needed_study("a yield" if tolerances else "a worst case within the spread")
        limits = ((1.0, requirement.at_least), (-1.0, requirement.at_most))
        signs = tuple(sign for sign, limit in limits if limit is not None)
        cases = worst_of(source, {_IT: quantity}, tolerances, requirement.at, samples=_SAMPLES, signs=signs).cases
        return [(math.nan, case.why["worst"].reason) if case.worst is None else (case.worst, "") for case in cases]

    def proved(self, requirement: Requirement, limits: tuple[float, float]) -> tuple[float, str]:
        """Return a limit if all sensors within the tolerances are proved to keep both.

        Else return the value of one that does not, or NaN if none is known, and what is to be said
        of it.
        """
        proofs = self._proofs(requirement, limits)
        proof = next((one for one in proofs if one.status != "proved"), proofs[0])
        is_verdict = proof.claim.kind == "stable"
        if proof.status == "proved":
            return VERDICTS["stable"] if is_verdict else proof.claim.limit, ""
        if proof.counterexample is None:
            return math.nan, f"proved for {100.0 * proof.searched.part:.3g} % of the tolerances; {proof.searched.why}"
        sensor = ", ".join(f"{name} = {value:.6g}" for name, value in proof.counterexample.items())
        reason = f"a sensor within the tolerances has {proof.shown}: {sensor}"
        if is_verdict:
            return VERDICTS["unstable"], reason
        has_none = math.isinf(proof.value) and not proof.claim.row.of_output  # the loop is unstable
        return math.nan if has_none else proof.value, reason

    def _proofs(self, requirement: Requirement, limits: tuple[float, float]) -> tuple[MarginProof, ...]:
        """Return what comes of the claims of a requirement: one for each limit."""
        quantity, tolerances = quantity_of(self.flat, requirement), _tolerances(requirement)
        at = requirement.at or AUTO
        source = self.graph if tolerances else self._needed_study("a proof over the spread")
        if isinstance(quantity, TransferPart):
            wanted = {quantity.output: [limit if math.isfinite(limit) else None for limit in limits]}
            biases, factors = (wanted if quantity.part == part else None for part in ("bias", "scale_factor"))
            return prove(
                source, tolerances=tolerances, input=quantity.input, at=at, bias=biases, scale_factor=factors
            ).proofs
        if isinstance(quantity, ResponseFigure):
            peak = {quantity.output: limits[1]}
            return prove(source, tolerances=tolerances, input=quantity.input, at=at, peak=peak).proofs
        if isinstance(quantity, Noise):
            return prove(source, tolerances=tolerances, at=at, noise={quantity.output: limits[1]}).proofs
        assert isinstance(quantity, LoopFigure | StabilityVerdict)
        kind = PROVABLE[quantity.figure] if isinstance(quantity, LoopFigure) else "stable"
        return (prove_margin(source, quantity.loop, kind, limits[0], tolerances, at=at),)

    @cached_property
    def flat(self) -> FlatGraph:
        """The graph without subgraphs, which can run; raises `ModelError`."""
        return plan(self.graph).graph

    def _yield(self, quantity: YieldOf) -> float:
        name, yields = quantity.limit or ALL_LIMITS, self.result.yields()
        if name not in yields:
            message, expected = f"the study has no limit {name}", ", ".join(yields) or "[study.limits]"
            raise Problem(message=message, key=TABLE, got=str(quantity), expected=expected).error
        return yields[name]

    def _needed_study(self, what: str) -> Study:
        if self.study is None:
            hint = "add [study] with spread and limits to the file, or name the study's file"
            problem = Problem(message=f"{what} is required, and there is no study", hint=hint, path=(TABLE,))
            raise self.graph.placed(problem).error
        return self.study


def verify(measurements: Measurements) -> list[Finding]:
    """Return a finding for each requirement of a graph, and for each margin its loops must have.

    One whose quantity cannot be had, or whose run fails, has no value and a reason; the others are
    verified all the same. Raises `ModelError` for a graph that cannot run.
    """
    flat = measurements.flat
    return [_of_variants(measurements, *named) for named in every_requirement(measurements.graph, flat)]


def every_requirement(graph: Graph, flat: FlatGraph) -> Iterator[tuple[str, Requirement]]:
    """Yield requirements of a graph by id, and of its loops, which are named by margin."""
    yield from graph.requirements.items()
    for name, loop in flat.loops.items():
        for margin, limit in loop.requirements.items():
            least = margin != "sensitivity_peak"
            key, text = f"{name}.{margin}", f"Margin of the loop {name}."
            yield key, Requirement(key, text, at_least=limit) if least else Requirement(key, text, at_most=limit)


def _of_variants(measurements: Measurements, name: str, requirement: Requirement) -> Finding:
    """Return what a requirement finds, of a study with variants in the one that is nearest to a limit or beyond it."""
    finding = finding_of(measurements, name, requirement)
    if requirement.tolerances != SPREAD and not isinstance(quantity_of(measurements.flat, requirement), YieldOf):
        return finding
    for variant, others in measurements.variants.items():
        found = finding_of(others, name, requirement)
        if found.room < finding.room:
            finding = replace(found, reason="; ".join(filter(None, (f"in the variant {variant}", found.reason))))
    return finding


def finding_of(measurements: Measurements, name: str, requirement: Requirement) -> Finding:
    """Return what one requirement finds."""
    limits = asked(measurements.flat, requirement)
    low, high = limits.at_least, limits.at_most
    try:
        if requirement.proved:
            values = [measurements.proved(requirement, (low, high))]
        else:
            values = measurements.values(requirement)
    except (ModelError, RunError) as error:
        values = [(math.nan, refused(error).reason)]
    missed = (of for of in values if not low <= of[0] <= high)
    value, reason = next(missed, min(values, key=lambda of: min(of[0] - low, high - of[0])))  # or next to its limit
    wanted = requirement.quantity
    quantity = wanted if isinstance(wanted, str) else str(quantity_of(measurements.flat, requirement))
    quantity += ", proved" if requirement.proved else ", worst case" if requirement.tolerances else ""
    return Finding(name, requirement.text, quantity, limits.unit, value, low, high, reason)


def _tolerances(requirement: Requirement) -> Mapping[str, Any]:
    """Return the tolerances of a requirement; none for those that are the spread of the study."""
    return {} if isinstance(requirement.tolerances, str) else requirement.tolerances


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
