"""The worst cases of quantities of a graph within tolerances, what makes them, and how much was looked at."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal
from proofmass.graphs.files.toml_reader import GraphSource, graph_from
from proofmass.graphs.model.call_numbers import SEED, refuse_counts
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.loops import read_moment
from proofmass.graphs.model.quantities import (
    AT_FREQUENCY,
    LoopFigure,
    Noise,
    Quantity,
    ResponseFigure,
    YieldOf,
    checked_quantity,
)
from proofmass.graphs.studies.study import Study
from proofmass.runner.analysis.linearisation.linearise import loops_of
from proofmass.runner.design.quantities.evaluator import Evaluator, Reasons
from proofmass.runner.design.quantities.stopping import InterruptedSearch
from proofmass.runner.design.worst.box import DOWN, UP, box_of
from proofmass.runner.design.worst.ranges import Range
from proofmass.runner.design.worst.search import BoxSearch, SearchedPlace, Side
from proofmass.runner.host.interrupts import interrupts
from proofmass.runner.host.notebook import Plotted, Told
from proofmass.runner.host.progress import Progress
from proofmass.runner.output.json_text import finite
from proofmass.runner.planning.plan import plan

CORNERS, SAMPLES = 256, 100
MOST_CORNERS, MOST_SAMPLES = 1 << 20, 10**6
_CONFIDENCE = 0.95
_HIGH_IS_BAD = ("sensitivity_peak", "overshoot", "settling_time", "peak", "delay", "rise_time")
_DEFAULT_FIGURES = ("gain_margin", "phase_margin")
_LISTED = 5  # corners in a table


@dataclass(frozen=True)
class OneAtATime:
    """A quantity with one parameter at its ends and all others nominal; None where undefined."""

    parameter: str
    at_low: float | None
    at_high: float | None


@dataclass(frozen=True)
class WorstCase:
    """The worst value of one quantity on one side, and where it is."""

    name: str
    quantity: Quantity
    side: str  # "lowest" or "highest"
    nominal: float | None
    worst: float | None  # None where a loop is unstable or a run fails
    first_order: float | None  # what the derivatives at the nominal values say
    values: Mapping[str, float]  # parameters by the names that were written
    places: Mapping[str, float]  # from -1, lowest, to 1, highest
    one_at_a_time: tuple[OneAtATime, ...]
    corners: tuple[tuple[str, float | None], ...]  # the worst: signs of the parameters in their order, and the value
    why: Reasons = field(default_factory=dict)  # of values that are None, by "nominal", "worst" and "PARAMETER, low"

    @property
    def inside(self) -> bool:
        """True if the worst case is at no corner."""
        return any(abs(place) < 1.0 for place in self.places.values())

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {
            "quantity": str(self.quantity),
            "unit": self.quantity.unit,
            "side": self.side,
            "nominal": finite(self.nominal),
            "worst": finite(self.worst),
            "first_order": finite(self.first_order),
            "at": dict(self.values),
            "places": dict(self.places),
            "inside": self.inside,
            "one_at_a_time": {o.parameter: [finite(o.at_low), finite(o.at_high)] for o in self.one_at_a_time},
            "without_value": {place: of.reason for place, of in self.why.items()},
            "corners": [{"signs": signs, "value": finite(value)} for signs, value in self.corners],
        }


@dataclass(frozen=True, eq=False, repr=False)
class WorstCases(Told, Plotted):
    """All worst cases, and how much of the box was looked at.

    >>> from proofmass import read_graph, worst
    >>> graph = read_graph("library:closed_loop_accelerometer")
    >>> found = worst(graph, tolerances={"torquer.gain": "5 %"}, samples=2)
    >>> found.all_corners, found.corners
    (True, 2)
    """

    ranges: tuple[Range, ...]  # of the parameters
    cases: tuple[WorstCase, ...]  # a worst value of each quantity and side
    corners: int  # that were tried
    random: int  # points that were tried
    evaluations: int  # points that were tried in all
    interrupted: bool  # True after Ctrl-C
    left_out: Mapping[str, str]  # what varies and does not count, with its reason

    @property
    def all_corners(self) -> bool:
        """True if every corner was tried."""
        return self.corners == 1 << len(self.ranges)

    @property
    def unseen(self) -> float:
        """Part of the box that may be worse than the worst, with a confidence of 95 %; by the random points."""
        return 1.0 - (1.0 - _CONFIDENCE) ** (1.0 / self.random) if self.random else 1.0

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {
            "ranges": {
                r.written: {"nominal": r.nominal, "low": r.low, "high": r.high, "unit": r.unit} for r in self.ranges
            },
            "cases": {case.name: case.as_data() for case in self.cases},
            "corners_tried": self.corners,
            "corners": 2 ** len(self.ranges),
            "random_points": self.random,
            "unseen_part_95": self.unseen,
            "evaluations": self.evaluations,
            "interrupted": self.interrupted,
            "left_out": dict(self.left_out),
        }


def worst(
    source: GraphSource | Study,
    quantities: Mapping[str, Mapping[str, Any]] | None = None,
    *,
    tolerances: Mapping[str, Any] | None = None,
    at: str = "",
    corners: int = CORNERS,
    samples: int = SAMPLES,
    seed: int = 0,
    progress: Progress | None = None,
) -> WorstCases:
    """Find how bad quantities of a graph can get within tolerances.

    `quantities` are tables by name, as goals of `[tune]` name them: `{"phase": {"loop": "main",
    "figure": "phase_margin"}}`; unless given, the gain and phase margins of all loops. `tolerances`
    maps parameters to
    "5 %", to a width with a unit or to a list of two values; a study brings everything that varies
    in it, normal deviates up to three standard deviations. The worst yield of a study is that
    within `tolerances` alone: its spread is in the yield.
    All corners are tried if there are no more than `corners`, and so many random `samples`.

    Raises `ModelError` with everything that is wrong.

    `source` is a graph, or a study with its graph. `at` is the operating point of `margins`. `seed`
    is that of the samples, and `progress` is called with the points that are tried and all points.

    >>> from proofmass import read_graph, worst
    >>> graph = read_graph("library:closed_loop_accelerometer")
    >>> found = worst(graph, tolerances={"torquer.gain": "5 %"}, samples=2)
    >>> [(case.name, round(case.nominal, 2), round(case.worst, 2)) for case in found.cases]
    [('main.gain_margin', 31.57, 31.14), ('main.phase_margin', 90.89, 90.68)]
    """
    source = source if isinstance(source, Study) else graph_from(source)
    graph = source.graph if isinstance(source, Study) else source
    refuse_counts(corners=(corners, 0, MOST_CORNERS), samples=(samples, 0, MOST_SAMPLES), seed=(seed, *SEED))
    try:
        read_moment(at)
    except Refusal as error:
        raise error.problem("at", at).error from None
    return worst_of(source, _quantities(graph, quantities), tolerances or {}, at, corners, samples, seed, progress)


def worst_of(
    source: Graph | Study,
    wanted: Mapping[str, Quantity],
    tolerances: Mapping[str, Any],
    at: str = "",
    corners: int = CORNERS,
    samples: int = SAMPLES,
    seed: int = 0,
    progress: Progress | None = None,
    signs: tuple[float, ...] = (),
) -> WorstCases:
    """Find the worst cases of quantities that have been read; `signs` are 1 for lowest, -1 for highest values."""
    graph = source.graph if isinstance(source, Study) else source
    yields = any(isinstance(quantity, YieldOf) for quantity in wanted.values())
    box = box_of(graph if yields else source, tolerances)
    ranges = box.ranges
    sides = {name: signs or _sides(quantity) for name, quantity in wanted.items()}
    searched = [Side(name, sign) for name, signs in sides.items() for sign in signs]
    expected = 2 * len(ranges) + samples + min(2 ** len(ranges), corners) + 20 * len(searched)
    with interrupts() as stop:
        evaluator = Evaluator(graph, wanted, at, box.widths(), source if isinstance(source, Study) else None)
        search = BoxSearch(evaluator, box, expected, progress, stop)
        interrupted = False
        try:
            search.search(searched, corners, samples, seed)
        except InterruptedSearch:
            interrupted = True
    if not search.cases:
        raise Problem(message="interrupted before anything was evaluated", key="worst").error
    return WorstCases(
        ranges=tuple(ranges),
        cases=tuple(_case(search, side, wanted[side.quantity], len(sides[side.quantity]) > 1) for side in searched),
        corners=sum(case.corner for case in search.cases.values()),
        random=len(search.random),
        evaluations=len(search.cases),
        interrupted=interrupted,
        left_out=box.left_out,
    )


def _quantities(graph: Graph, given: Mapping[str, Mapping[str, Any]] | None) -> dict[str, Quantity]:
    flat = flatten(graph)
    tables: Mapping[str, Any] = given or {
        f"{loop}.{figure}": {"loop": loop, "figure": figure} for loop in _loops(graph) for figure in _DEFAULT_FIGURES
    }
    read, problems = dict[str, Quantity](), list[Problem]()
    for name, table in tables.items():
        try:
            read[name] = checked_quantity(table, flat)
        except Refusal as error:
            key = f"{name}.{error.key}" if error.key else name
            got, expected = error.got, error.expected
            problems.append(Problem(message=str(error), key=key, got=got, expected=expected, hint=error.hint))
    if problems:
        raise ModelError([graph.placed(problem) for problem in problems])
    return read


def _loops(graph: Graph) -> list[str]:
    planned = plan(graph)
    try:
        return [*loops_of(planned)]
    except ModelError as error:
        hint = "name a quantity: --measure NAME, --noise OUTPUT, --scale-factor OUTPUT"
        raise ModelError([replace(problem, hint=problem.hint and hint) for problem in error.problems]) from error


def _sides(quantity: Quantity) -> tuple[float, ...]:
    """Return the sides on which a quantity is bad: 1 low, -1 high; both if no side is good."""
    if isinstance(quantity, ResponseFigure) and quantity.figure in AT_FREQUENCY:
        return (1.0, -1.0)
    if isinstance(quantity, LoopFigure | ResponseFigure):
        return (-1.0,) if quantity.figure in _HIGH_IS_BAD else (1.0,)
    if isinstance(quantity, YieldOf):
        return (1.0,)
    return (-1.0,) if isinstance(quantity, Noise) else (1.0, -1.0)


def _case(search: BoxSearch, side: Side, quantity: Quantity, both: bool) -> WorstCase:
    size, ranges = len(search.box.ranges), search.box.ranges
    nominal, corner = search.cases[(0.0,) * size], search.worst(side)
    known = search.box.values(corner.place)
    word = "lowest" if side.sign > 0.0 else "highest"
    singles, places = [], {"nominal": nominal, "worst": corner}
    for number, wanted in enumerate(ranges):
        ends = [tuple(sign if i == number else 0.0 for i in range(size)) for sign in (-1.0, 1.0)]
        low, high = (search.cases.get(end) for end in ends)
        singles.append(OneAtATime(wanted.written, _value(low, side), _value(high, side)))
        places |= {f"{wanted.written}, {end}": at for end, at in (("low", low), ("high", high)) if at}
    begin, first_order = _value(nominal, side), None
    if begin is not None:
        ways = (search.gradient(nominal, side, way) for way in (UP, DOWN))
        first_order = begin - side.sign * search.box.largest_change(*ways)
    corners = sorted(
        (c for c in search.cases.values() if c.corner), key=lambda c: search.badness(c, side), reverse=True
    )
    return WorstCase(
        name=f"{side.quantity}, {word}" if both else side.quantity,
        quantity=quantity,
        side=word,
        nominal=begin,
        worst=_value(corner, side),
        first_order=first_order,
        values={r.written: known.get(r.name, r.at(part)) for r, part in zip(ranges, corner.place, strict=True)},
        places={r.written: part for r, part in zip(ranges, corner.place, strict=True)},
        one_at_a_time=tuple(singles),
        corners=tuple(
            ("".join("+" if part > 0.0 else "-" for part in case.place), _value(case, side))
            for case in corners[:_LISTED]
        ),
        why={place: at.why[side.quantity] for place, at in places.items() if side.quantity in at.why},
    )


def _value(case: SearchedPlace | None, side: Side) -> float | None:
    reading = case.readings[side.quantity] if case is not None else None
    return None if reading is None else reading.value
