"""The map of a loop over one period in balls: every sensor whose parameters lie in a box has a map within it.

The blocks' own functions are called with polynomials for their parameters, and with dual numbers on
them for signals. The operating point is the start of the run, tick 0, or one at which the sensors
rest.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem, problem_of_output
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints, linearised
from proofmass.runner.analysis.linearisation.orbit import OrbitPoint
from proofmass.runner.analysis.linearisation.seeds import held_in
from proofmass.runner.analysis.linearisation.tick_maps import between
from proofmass.runner.derivatives.ball import is_zero
from proofmass.runner.derivatives.dual import SIGNALS, slopes_of
from proofmass.runner.derivatives.dual_ticks import DualTicks
from proofmass.runner.design.proof.ball_ticks import BallTicks, advanced, with_balls
from proofmass.runner.design.proof.enclosed import RestPoint
from proofmass.runner.design.proof.places import check_unseen, returned
from proofmass.runner.design.proof.rest_point import RestRun
from proofmass.runner.design.proof.tick_products import SteppedBallTicks, TickProducts, seeded, tick_products
from proofmass.runner.host.arrays import Truths
from proofmass.runner.plan.memory import Memory, start
from proofmass.runner.plan.planned import Plan

MOST_STATES, MOST_VALUES = 64, 32  # of a map, and of a loop's wire in a period: matrices are met thousands of times
_SEARCH = "search with `proofmass worst`"
_OF_START = "a loop whose margins are those of the start of the run"
MatrixRows = list[list[Any]]  # of balls and numbers


@dataclass(frozen=True)
class BallMap:
    """MatrixRows [A B] and below them [C D] of an open loop: numbers, balls, and polynomials of the coordinates."""

    order: int
    rows: MatrixRows
    kept: "Kept"


@dataclass(frozen=True)
class Kept:
    """Numbers of the states that lie between the input and the output, and of the values at both that matter."""

    states: tuple[int, ...]
    inputs: tuple[int, ...]
    outputs: tuple[int, ...]
    rest: RestPoint | None = None  # where the sensors of the box rest


class BallRun:
    """A period from a run's start in balls: what is between two ends at its operating point."""

    def __init__(self, plan: Plan, ends: Ends, point: OrbitPoint, rest: RestRun | None = None) -> None:
        self._plan, self._ends, self._point, self._rest = plan, ends, point, rest
        self._blocks = ends.blocks(plan)[0]

    def rest(self, parameters: Mapping[str, Any]) -> RestPoint | None:
        """Return where sensors with such parameters rest, None at the start of a run; raises `UndecidedError`."""
        return None if self._rest is None else self._rest.enclosed(parameters)

    def rows(self, parameters: Mapping[str, Any], rest: RestPoint | None = None) -> tuple[MatrixRows, int]:
        """Return the map of all states for parameters that hold polynomials, and how many these are.

        Raises `UndecidedError` where a block decides differently within the box.
        """
        plan, begin = self._there(parameters, rest)
        rings, entries = self._point.rings, self._point.map.states
        if self._rest is not None:
            entries = (*entries, *(place.entry for place in self._rest.places))
        seeded(begin, entries, rings)
        engine = self._engine(plan, begin)
        last = begin.tick + self._point.ticks
        if self._rest is not None and rest is not None:
            for tick, there in self._rest.on_the_way(rest.values, last):
                advanced(engine, tick)
                self._rest.hold(engine.memory(), there)
        advanced(engine, last)
        memory = engine.memory()
        values = [held_in(memory, entry, rings) for entry in entries]
        values += [value for node in self._ends.outputs for value in engine.recorded[node]]
        columns = [*entries, *self._columns(engine)]
        rows = [[slopes_of(value, SIGNALS).get(key, 0.0) for key in columns] for value in values]
        if self._rest is None or rest is None or not rest.places:
            return rows, len(entries)
        along = dict(zip(self._rest.entries, rest.along, strict=True))
        kept = entries[: -len(rest.places)]
        curves = [along.get(entry, [0.0] * len(rest.places)) for entry in kept]
        moving = [i for i, entry in enumerate(entries) if entry in along or i >= len(kept)]  # others are coefficients
        check_unseen(rows, len(entries), moving, curves)
        return returned(rows, len(entries), curves), len(kept)

    def ticks(self, parameters: Mapping[str, Any], kept: "Kept") -> TickProducts:
        """Return the ticks of the loop of some states for parameters that hold polynomials."""
        plan = with_balls(self._plan, parameters)
        begin, ends = self._begin(plan), self._ends
        rings, entries = self._point.rings, self._point.map.states
        places = seeded(begin, entries, rings)
        engine = SteppedBallTicks(plan, begin, self._blocks, ends.inputs, ends.outputs, ends.cut, False)
        states = [entries[i] for i in kept.states]
        return tick_products(engine, places, begin.tick + self._point.ticks, rings, states)

    def _there(self, parameters: Mapping[str, Any], rest: RestPoint | None) -> tuple[Plan, Memory]:
        """Return the plan with such parameters, and the memory from which the period goes on."""
        plan = with_balls(self._plan, parameters)
        if self._rest is None or rest is None:
            return plan, self._begin(plan)
        return plan, self._rest.memory_of(plan, rest.values, rest.places, seeded=False)

    def _begin(self, plan: Plan) -> Memory:
        """Return the memory from which the period goes on, at the start of a run."""
        return start(plan)

    def _engine(self, plan: Plan, begin: Memory) -> DualTicks:
        ends = self._ends
        return BallTicks(plan, begin, self._blocks, ends.inputs, ends.outputs, ends.cut, False)

    def _columns(self, engine: DualTicks) -> list[Any]:
        """Return what enters, in order."""
        return sorted(engine.injected, key=lambda key: key[2])


class Starting:
    """Subject of a claim at the start of a run or at rest: its map over any box of parameters."""

    _run: BallRun
    period: float  # s
    values: int  # of a wire in it
    in_ticks: bool = False  # whether its ticks are known one by one
    places: int = 0  # last coordinates that are places of what comes to no rest

    def map(self, parameters: Mapping[str, Any], kept: Kept | None = None) -> BallMap:
        """Return the map for parameters that hold polynomials, of what is `kept`.

        Raises `UndecidedError` where a block decides differently within the box.
        """
        rest = self._run.rest(parameters)
        rows, order = self._run.rows(parameters, rest)
        rows = self._seen(rows, order)
        kept = replace(self._kept(rows, order), rest=rest) if kept is None else kept
        down, across = ([*kept.states, *(order + end for end in ends)] for ends in (kept.outputs, kept.inputs))
        return BallMap(len(kept.states), [[rows[i][j] for j in across] for i in down], kept)

    def ticks(self, parameters: Mapping[str, Any], kept: Kept) -> TickProducts:
        """Return the ticks of a loop for polynomials as parameters, of the states `kept`."""
        return self._run.ticks(parameters, kept)

    def _seen(self, rows: MatrixRows, order: int) -> MatrixRows:
        """Return the map as the claim has it."""
        return rows

    def _kept(self, rows: MatrixRows, order: int) -> Kept:
        """Return what matters: all values of inputs and outputs."""
        inputs, outputs = range(len(rows[0]) - order), range(len(rows) - order)
        return Kept(tuple(states_between(rows, order)), tuple(inputs), tuple(outputs))


class StartingLoop(Starting):
    """A loop at the start of a run: the states of its map, and that map over boxes."""

    def __init__(self, plan: Plan, node: Endpoint, rest: RestRun | None = None) -> None:
        """Raises `ModelError` where margins are not those of the start: the loop changes later."""
        ends, signal = Ends((node,), (node,), cut=True), ".".join(node)
        point = at_start(plan, ends) if rest is None else rest.map_between(ends)
        later = point.map.tick or (point.moves and OperatingPoints(plan).about_loop(node)[0].told)
        if rest is None and later:
            raise changes_later(plan, f"the loop through {signal}", node, _OF_START)
        between = point.map.between()
        if not between.order:
            where = "at the start of the run" if rest is None else "at rest"
            message = f"what goes in at {signal} does not come back {where}"
            open_there = plan.graph.placed(Problem(message=message, key=signal, path=("blocks", node[0])))
            raise ChangesLaterError([open_there]) if rest is None else open_there.error
        if between.order > MOST_STATES or len(between.outputs) > MOST_VALUES:
            values = f"{len(between.outputs)} values of its wire in a period"
            has = f"the loop through {signal} has {between.order} states and {values}"
            most = f"{MOST_STATES} states and {MOST_VALUES} values"
            raise too_large(plan, has, node, most, "open the loop at its slowest wire with --loop")
        self._run, self.in_ticks = BallRun(plan, ends, point, rest), rest is None
        self.places = 0 if rest is None else len(rest.places)
        self.period, self.values = between.period, len(between.inputs)  # s, and values of the wire

    def _kept(self, rows: MatrixRows, order: int) -> Kept:
        """Return what matters: a value that nothing reads, or that follows nothing, is not a part of the loop."""
        states, wire = states_between(rows, order), range(order, len(rows))
        enter = {j for i in (*states, *wire) for j in wire if not is_zero(rows[i][j])}
        leave = {i for i in wire for j in (*states, *wire) if not is_zero(rows[i][j])}
        values = tuple(sorted(place - order for place in enter & leave))
        return Kept(tuple(states), values, values)


def states_between(rows: MatrixRows, order: int) -> list[int]:
    """Return the states that the input reaches and that reach the output, by what is not exactly zero anywhere."""
    links: Truths = np.array([[not is_zero(value) for value in row] for row in rows], dtype=bool)
    entered: Truths = np.any(links[:order, order:], axis=1)
    read: Truths = np.any(links[order:, :order], axis=0)
    return between(links[:order, :order], entered, read)


class ChangesLaterError(ModelError):
    """Error of what is not that of the start of the run later."""


def at_start(plan: Plan, ends: Ends, tick: int = 0) -> OrbitPoint:
    """Return the map between ends at the start; raises `ChangesLaterError` without one."""
    try:
        return linearised(plan, tick).point_of(ends)
    except ModelError as error:
        raise ChangesLaterError(error.problems) from None


def changes_later(plan: Plan, what: str, node: Endpoint, expected: str = "") -> ChangesLaterError:
    """Return the error of what is not that of the start of the run later."""
    problem = problem_of_output(
        node,
        message=f"{what} changes after the start",
        expected=expected,
        hint="proofs are about the start of a run; `proofmass worst` searches at other operating points",
    )
    return ChangesLaterError([plan.graph.placed(problem)])


def too_large(plan: Plan, has: str, node: Endpoint, most: Any, hint: str = _SEARCH) -> ModelError:
    """Return the error of what has more states or values than matrices are met with."""
    place, expected = ("blocks", node[0]), f"at most {most}"
    return plan.graph.placed(Problem(message=has, key=".".join(node), expected=expected, hint=hint, path=place)).error
