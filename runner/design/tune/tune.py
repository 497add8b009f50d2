"""Parameters of a graph that meet its goals, and what binds them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.optimize

from proofmass.graphs.files.toml_reader import GraphSource, graph_from
from proofmass.graphs.model.changes import with_parameters
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.tuning.build import tuning_of
from proofmass.graphs.tuning.tuning import Goal, Tuning
from proofmass.runner.design.tune.goals_at import MET, GoalRow, GoalsAt, TriedPoint, worst_reading
from proofmass.runner.design.tune.search import KEPT, Search
from proofmass.runner.host.interrupts import interrupts
from proofmass.runner.host.notebook import Plotted, Told
from proofmass.runner.host.progress import Progress
from proofmass.runner.output.json_text import finite

_ACTIVE = 1e-3  # slack up to which a goal may bind
_DIGITS = (9, 12, 17)  # of numbers written: as few as miss no goal: a yield has steps
_COUNTS = 1e-6  # of a multiplier
_FEW = 8  # samples of a search that begins at a good point


@dataclass(frozen=True)
class TunedGoal:
    """A goal: what is wanted, and its worst value over all operating points before and after."""

    name: str
    goal: Goal
    before: float | None
    after: float | None
    case: str  # in which it is worst
    price: (
        float  # change of the objective, relative, for one per cent of the limit; of the conflict where one is missed
    )
    reachable: float | None = None  # of a missed goal: what it reaches with other hard goals met
    why: str = ""  # it has no value after
    size: float = 0.0  # of the quantity: a limit of zero is kept up to a rounding of that

    @property
    def met(self) -> bool:
        """True if its limits are kept."""
        if self.after is None:
            return False
        return all(sign * (self.after - limit) >= -MET * (abs(limit) or self.size) for sign, limit in self.goal.limits)

    @property
    def binds(self) -> bool:
        """True if the result would be better without it."""
        return self.price > _COUNTS

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {
            "quantity": str(self.goal.quantity),
            "unit": self.goal.quantity.unit,
            "wanted": self.goal.wanted,
            "before": finite(self.before),
            "after": finite(self.after),
            "without_value": self.why or None,
            "met": self.met,
            "worst_at": self.case,
            "binds": self.binds,
            "price_of_one_percent": self.price,
            "reachable": finite(self.reachable),
        }


@dataclass(frozen=True, eq=False, repr=False)
class Tuned(Told, Plotted):
    """The result of a search: parameters, goals, and what binds.

    >>> from proofmass import read_graph, tune
    >>> graph = read_graph("library:closed_loop_accelerometer")
    >>> tuned = tune(
    ...     graph,
    ...     free={"pid.integral": {"at_least": "10 1/s", "at_most": "1000 1/s"}},
    ...     goals={"stable": {"loop": "main", "figure": "gain_margin", "at_least": "20 dB"}},
    ...     samples=4,
    ...     starts=1,
    ... )
    >>> list(tuned.changes), tuned.graph.name
    (['pid.integral'], 'closed-loop accelerometer')
    """

    tuning: Tuning  # what was asked for
    before: Mapping[str, float]  # by names in the flat graph
    parameters: Mapping[str, float]  # by names in the flat graph
    goals: tuple[TunedGoal, ...]  # with their values before and after
    at_bounds: Mapping[str, str]  # parameters that end at a bound which binds: "lower" or "upper"
    evaluations: int  # points that were tried
    interrupted: bool  # True after Ctrl-C
    objective: float  # of the worst goal without a limit, about the logarithm of its part of before; 0 without one

    @property
    def met(self) -> bool:
        """True if all hard goals are met, and every goal has a value."""
        return not self.without_value and all(goal.met for goal in self.goals if goal.goal.hard)

    @property
    def without_value(self) -> tuple[str, ...]:
        """The goals without a value: then no point that was tried gives one to all goals."""
        return tuple(goal.name for goal in self.goals if goal.after is None)

    @property
    def changes(self) -> dict[str, float | str]:
        """The parameters with their units, by the names that the graph file has."""
        return as_written(self.tuning, self.parameters)

    @cached_property
    def graph(self) -> Graph:
        """The graph with these parameters."""
        return with_parameters(self.tuning.graph, self.changes)

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {
            "met": self.met,
            "interrupted": self.interrupted,
            "evaluations": self.evaluations,
            "parameters": {
                self.tuning.written.get(name, name): {
                    "before": self.before[name],
                    "after": value,
                    "unit": self.tuning.unit_of(name),
                    "at_least": self.tuning.free[name].at_least,
                    "at_most": self.tuning.free[name].at_most,
                    "binds_at": self.at_bounds.get(name),
                }
                for name, value in self.parameters.items()
            },
            "goals": {goal.name: goal.as_data() for goal in self.goals},
        }


def as_written(tuning: Tuning, parameters: Mapping[str, float]) -> dict[str, float | str]:
    """Return parameters with their units, by the names that the graph file has."""
    units = {name: tuning.unit_of(name) for name in parameters}
    return {
        tuning.written.get(name, name): f"{value!r} {units[name]}" if units[name] != "1" else value
        for name, value in parameters.items()
    }


def tune(graph: GraphSource | Tuning, *, progress: Progress | None = None, **tables: Any) -> Tuned:
    """Find parameters of a graph that meet goals.

    `free` and `goals`, and if wanted `points`, `tolerances`, `at`, `starts`, `samples` and `seed`,
    are tables and numbers as in `[tune]` of a graph file; or give a `Tuning`, as `read_tuning`
    returns it. Ctrl-C ends the search; the best point so far is the result.

        tune(graph, free={"pid.integral": {"at_least": "1 1/s", "at_most": "100 1/s"}},
             goals={"phase": {"loop": "main", "figure": "phase_margin", "at_least": "60 deg"},
                    "quiet": {"noise": "dac.code", "minimise": True}})

    Raises `ModelError` with everything that is wrong with the tables.

    `graph` has values to start from, `tables` are these tables. `progress` is called with the
    points that are tried and all points.

    >>> from proofmass import read_graph, tune
    >>> graph = read_graph("library:closed_loop_accelerometer")
    >>> tuned = tune(
    ...     graph,
    ...     free={"pid.integral": {"at_least": "10 1/s", "at_most": "1000 1/s"}},
    ...     goals={"stable": {"loop": "main", "figure": "gain_margin", "at_least": "20 dB"}},
    ...     samples=4,
    ...     starts=1,
    ... )
    >>> tuned.met
    True
    """
    tuning = graph if isinstance(graph, Tuning) else tuning_of(graph_from(graph), **tables)
    goals = GoalsAt(tuning)
    with interrupts() as stop:
        search = Search(goals, progress, stop)
        best = search.run()
        reachable = {} if search.interrupted else _reachable(search, best)
        goals.note = lambda at: None
        best = _rounded(goals, best)
    prices, bounds = _multipliers(best, tuning)
    return Tuned(
        tuning=tuning,
        before=tuning.nominal,
        parameters=best.values,
        goals=tuple(_outcome(goals, name, search.first, best, prices, reachable) for name in tuning.goals),
        at_bounds=bounds,
        evaluations=search.count,
        interrupted=search.interrupted,
        objective=best.objective,
    )


def _rounded(goals: GoalsAt, best: TriedPoint) -> TriedPoint:
    """Return the point with as few digits as keep the goals that it keeps."""
    at = best
    for digits in _DIGITS:
        numbers = {name: float(f"{value:.{digits}g}") for name, value in best.values.items()}
        at = goals.at_values({name: goals.tuning.free[name].inside(value) for name, value in numbers.items()})
        if at.violation <= max(best.violation, KEPT):
            break
    return at


def _outcome(
    goals: GoalsAt,
    name: str,
    first: TriedPoint,
    best: TriedPoint,
    prices: Mapping[str, float],
    reachable: Mapping[str, float],
) -> TunedGoal:
    goal = goals.tuning.goals[name]
    _, before = worst_reading(first, name, goal)
    case, after = worst_reading(best, name, goal)
    return TunedGoal(
        name,
        goal,
        before.value if before else None,
        after.value if after else None,
        case,
        prices.get(name, 0.0),
        reachable.get(name),
        best.why[case][name].reason if after is None else "",
        goals.size(name),
    )


def _multipliers(at: TriedPoint, tuning: Tuning) -> tuple[dict[str, float], dict[str, str]]:
    """Return by how much each goal worsens the objective, and the bounds that do.

    At an optimum the gradient of the goal is a sum, with positive factors, of gradients of binding
    limits. Where a hard goal is missed, the worst slack is sought.
    """
    missed = at.violation > MET
    if not at.defined or not (missed or at.objectives):
        return {}, {}
    if missed:
        sought = [row._replace(value=-row.value, gradient=-row.gradient) for row in at.slacks]
        worst, independent = [row for row in sought if row.value >= at.violation - _ACTIVE], list[GoalRow]()
    else:
        worst = [row for row in at.objectives if row.value >= at.objective - _ACTIVE]
        independent = [row for row in at.slacks if row.value <= _ACTIVE]
    sides = [(i, "lower") for i, part in enumerate(at.parts) if part <= 1e-6]
    sides += [(i, "upper") for i, part in enumerate(at.parts) if part >= 1.0 - 1e-6]
    size = len(at.parts)
    edges = [np.eye(size)[i] * (1.0 if side == "lower" else -1.0) for i, side in sides]
    columns = [row.gradient for row in worst] + [-row.gradient for row in independent] + [-edge for edge in edges]
    scale = max((float(np.max(np.abs(column), initial=0.0)) for column in columns), default=0.0) or 1.0
    table = np.array(columns).T / scale
    table = np.vstack([table, [1.0] * len(worst) + [0.0] * (len(independent) + len(edges))])
    factors = scipy.optimize.nnls(table, np.append(np.zeros(size), 1.0))[0]
    prices = dict[str, float]()
    rows, factor_of = (worst, 1.0) if missed else (independent, 0.01)
    for row, factor in zip(rows, factors[0 if missed else len(worst) :], strict=False):
        prices[row.goal] = prices.get(row.goal, 0.0) + factor_of * float(factor)
    names = list(tuning.free)
    on_edges = zip(sides, factors[len(worst) + len(independent) :], strict=True)
    return prices, {names[i]: side for (i, side), factor in on_edges if factor > 1e-3}


def _reachable(search: Search, best: TriedPoint) -> dict[str, float]:
    """Return, of each goal a conflict misses, the best value that the other hard goals leave."""
    if best.violation <= MET or not best.defined:
        return {}
    tuning, reached = search.goals.tuning, {}
    missed = {row.goal for row in best.slacks if row.value >= -best.violation - _ACTIVE and row.value < -MET}
    for name in missed:
        goal = tuning.goals[name]
        if len(goal.limits) != 1:
            continue
        sign = goal.limits[0][0]
        others = {n: g for n, g in tuning.goals.items() if g.hard and n != name}
        wanted = Goal(goal.quantity, minimise=sign < 0.0, maximise=sign > 0.0)
        narrower = replace(tuning, goals={**others, name: wanted}, samples=_FEW, starts=1)
        alone = Search(GoalsAt(narrower), None, search.stop)
        alone.seen = [best.parts]
        found = alone.run()
        if found.violation <= MET:
            reading = worst_reading(found, name, wanted)[1]
            if reading is not None:
                reached[name] = reading.value
    return reached
