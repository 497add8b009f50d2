"""The map of a loop over one period in balls: every sensor whose parameters lie in a box has a map within it.

The blocks' own functions are called with balls for their parameters, and with dual numbers on them: first for signals,
and within, twice, for the parameters. The operating point is the start of the run, tick 0.
"""

import copy
import types
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import flint

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.digraph import reached
from proofmass.graphs.model.graph import Endpoint, split
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints, linearised
from proofmass.runner.analysis.linearisation.orbit import OrbitPoint
from proofmass.runner.analysis.linearisation.seeds import at_place, held_in, place_of, put
from proofmass.runner.derivatives.ball import Ball, UndecidedError
from proofmass.runner.derivatives.dual import PARAMETERS, SIGNALS, Dual, dual, slopes_of
from proofmass.runner.derivatives.dual_groups import DualAdvance
from proofmass.runner.derivatives.dual_plan import dual_constants, dual_start
from proofmass.runner.derivatives.dual_ticks import DualTicks
from proofmass.runner.plan.bindings import Binding, Time
from proofmass.runner.plan.memory import Memory, start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.plan.solver import Solver
from proofmass.runner.reference.advance import Advance
from proofmass.runner.reference.interpret import TickError

MOST_STATES, MOST_VALUES = 64, 32  # of a map, and of a loop's wire in a period: matrices are met thousands of times
_OF_START = "a loop whose margins are those of the start of the run"
MatrixRows = list[list[Any]]  # of balls and numbers


FIRST, SECOND = PARAMETERS, PARAMETERS - 1  # levels of the first and of the second derivative by coordinates
VARIED = -1  # direction of all that varies, so that converters do not round it


@dataclass(frozen=True)
class BallMap:
    """MatrixRows [A B] and below them [C D] of an open loop: numbers and balls, dual in the coordinates of the box."""

    order: int
    rows: MatrixRows
    kept: "Kept"


@dataclass(frozen=True)
class Kept:
    """Numbers of the states that lie between the input and the output, and of the values of the wire that matter."""

    states: tuple[int, ...]
    values: tuple[int, ...]
    rest: Any = None  # where the sensors of the box rest, within which those of its parts do


def coordinate(value: Any, number: int) -> Any:
    """Return a ball or number as the coordinate of a number, with its first and second derivative."""
    return dual(dual(value, {number: 1.0}, SECOND), {number: 1.0}, FIRST)


class Resting(Protocol):
    """Points of rest or orbits of sensors, as `RestRun` encloses them."""

    orbit: float  # s, after which it comes round; 0 where it stands still

    def enclosed(self, parameters: Mapping[str, Any], within: Any = None) -> Any:
        """Return where all sensors with such parameters rest."""
        ...

    def on_the_way(self, values: Sequence[Any], last: int) -> Iterator[tuple[int, Sequence[Any]]]:
        """Yield the ticks before the last one at which it is known where they are, with the numbers there."""
        ...

    def values(self, parameters: Mapping[str, Any], rest: Any, moves: bool) -> list[Any]:
        """Return the numbers there, which move with the parameters or are any within reach."""
        ...

    def memory_of(self, plan: Plan, values: Sequence[Any], seeded: bool = True) -> Memory:
        """Return the memory with these numbers, and the coefficients of a plan."""
        ...

    def hold(self, memory: Memory, values: Sequence[Any]) -> None:
        """Put these numbers back into a memory after a tick, with the slopes that it has."""
        ...

    def map_between(self, ends: Ends) -> OrbitPoint:
        """Return the map between some ends about the point of rest of the sensor as it is."""
        ...


def varied(value: Any) -> Any:
    """Return a parameter with a direction: what varies is never rounded by a converter."""
    return value if isinstance(value, Dual) else dual(value, {VARIED: 1.0}, FIRST)


class BallTicks(DualTicks):
    """Ticks whose numbers may be balls: no group is moved by the matrices of a run, which are rounded, nor is time."""

    def _advance(self, plan: Plan, solver: Solver, integrated: bool) -> Advance:
        return DualAdvance(plan, solver.group, False)

    def _getter(self, binding: Binding) -> Callable[[int], Any]:
        base = self.filled.schedule.base_rate
        if isinstance(binding, Time):
            return lambda tick: Ball(flint.arb(tick * base.denominator) / base.numerator).widened()
        return super()._getter(binding)


class BallRows(Protocol):
    """An open loop in balls: `BallRun` over a period, or rates in continuous time."""

    def rest(self, parameters: Mapping[str, Any], kept: "Kept | None") -> Any:
        """Return where sensors with such parameters rest, None at the start of a run."""
        ...

    def rows(self, parameters: Mapping[str, Any], rest: Any = None) -> tuple[MatrixRows, int]:
        """Return the map of all states for parameters that hold balls, and how many these are."""
        ...


class BallRun:
    """A period from the start of a run in balls: what is between two ends at its operating point."""

    def __init__(self, plan: Plan, ends: Ends, point: OrbitPoint, rest: "Resting | None" = None) -> None:
        self._plan, self._ends, self._point, self._rest = plan, ends, point, rest
        self._blocks = ends.blocks(plan)[0]

    def rest(self, parameters: Mapping[str, Any], kept: "Kept | None") -> Any:
        """Return where sensors with such parameters rest, None at the start of a run; raises `UndecidedError`."""
        return None if self._rest is None else self._rest.enclosed(parameters, None if kept is None else kept.rest)

    def rows(self, parameters: Mapping[str, Any], rest: Any = None, moves: bool = True) -> tuple[MatrixRows, int]:
        """Return the map of all states for parameters that hold balls, and how many these are.

        The point of rest `moves` with the parameters, or is any point within its reach.

        Raises `UndecidedError` where a block decides differently within the box.
        """
        if self._rest is not None:
            parameters = {name: varied(value) for name, value in parameters.items()}
        plan = with_balls(self._plan, parameters)
        at_rest = [] if self._rest is None else self._rest.values(parameters, rest, moves)
        begin = self._begin(plan) if self._rest is None else self._rest.memory_of(plan, at_rest, seeded=False)
        rings, entries = self._point.rings, self._point.map.states
        for entry in entries:
            place = place_of(begin, entry, rings)
            put(begin, place, at_place(begin, place) + dual(0.0, {entry: 1.0}, SIGNALS))
        engine = self._engine(plan, begin)
        last = begin.tick + self._point.ticks
        if self._rest is not None:
            for tick, there in self._rest.on_the_way(at_rest, last):
                advanced(engine, tick)
                self._rest.hold(engine.memory(), there)
        advanced(engine, last)
        memory = engine.memory()
        values = [held_in(memory, entry, rings) for entry in entries]
        values += [value for node in self._ends.outputs for value in engine.recorded[node]]
        columns = [*entries, *self._columns(engine)]
        return [[slopes_of(value, SIGNALS).get(key, 0.0) for key in columns] for value in values], len(entries)

    def _begin(self, plan: Plan) -> Memory:
        """Return the memory from which the period goes on, at the start of a run."""
        return start(plan)

    def _engine(self, plan: Plan, begin: Memory) -> DualTicks:
        ends = self._ends
        return BallTicks(plan, begin, self._blocks, ends.inputs, ends.outputs, ends.cut, False)

    def _columns(self, engine: DualTicks) -> list[Any]:
        """Return what enters, in order."""
        return sorted(engine.injected, key=lambda key: key[2])


def advanced(engine: DualTicks, tick: int) -> None:
    """Advance an engine in balls to a tick; raises `UndecidedError` where a block decides differently within them."""
    try:
        engine.advance(tick, ())
    except TickError as error:
        cause = error.__cause__ or error.value
        raise UndecidedError(f"{error.at}: {cause}") from error


class StartingLoop:
    """A loop at the start of a run: the states of its map, and that map over any box of parameters."""

    def __init__(self, plan: Plan, node: Endpoint, rest: Resting | None = None) -> None:
        """Raises `ModelError` where margins are not those of the start: the loop changes later."""
        ends, signal = Ends((node,), (node,), cut=True), ".".join(node)
        point = at_start(plan, ends) if rest is None else rest.map_between(ends)
        later = point.map.tick or (point.moves and OperatingPoints(plan).about_loop(node)[0].told)
        if rest is None and later:
            raise ChangesLaterError([plan.graph.placed(changes_later(f"the loop through {signal}", node, _OF_START))])
        between = point.map.between()
        if not between.order:
            raise plan.graph.placed(_not_a_loop(node)).error
        if between.order > MOST_STATES or len(between.outputs) > MOST_VALUES:
            values = f"{len(between.outputs)} values of its wire in a period"
            has = f"the loop through {signal} has {between.order} states and {values}"
            most, hint = (
                f"{MOST_STATES} states and {MOST_VALUES} values",
                "open the loop at its slowest wire with --loop",
            )
            raise plan.graph.placed(too_large(has, node, most, hint)).error
        self._run: BallRows = BallRun(plan, ends, point, rest)
        self.period, self.values = between.period, len(between.inputs)  # s, and values of the wire in it

    def map(self, parameters: Mapping[str, Any], kept: Kept | None = None) -> BallMap:
        """Return the map for parameters that hold balls, dual in the coordinates of a box, of what is `kept`.

        Raises `UndecidedError` where a block decides differently within the box.
        """
        rest = self._run.rest(parameters, kept)
        rows, order = self._run.rows(parameters, rest)
        kept = replace(_kept(rows, order), rest=rest) if kept is None else kept
        places = [*kept.states, *(order + value for value in kept.values)]
        return BallMap(len(kept.states), [[rows[i][j] for j in places] for i in places], kept)


def with_balls(plan: Plan, parameters: Mapping[str, Any]) -> Plan:
    """Return a plan whose blocks have other parameters, which may be balls, with all that follows from them.

    `parameters` are named `"block.parameter"`.
    """
    moved: dict[str, dict[str, Any]] = {}
    for name, value in parameters.items():
        owner, parameter = split(name)
        moved.setdefault(owner, {})[parameter] = value
    blocks, constants, starts, buffers = dict(plan.blocks), dict(plan.constants), dict(plan.starts), dict(plan.buffers)
    for name, values in moved.items():
        block = copy.copy(plan.blocks[name])
        vars(block).update(values)
        blocks[name] = block
        given = types.SimpleNamespace(**{p: getattr(block, p) for p in type(block).parameters})
        if not plan.is_driven(name):
            constants[name] = dual_constants(block, given, plan.block_period(name))
        if "start" in type(block).functions:
            starts[name], filled = dual_start(plan, name, given)
            buffers |= filled
    return replace(plan, blocks=blocks, constants=constants, starts=starts, buffers=buffers)


def _kept(rows: MatrixRows, order: int) -> Kept:
    """Return what matters: a value that nothing reads, or that follows nothing, is not a part of the loop."""
    states = states_between(rows, order)
    wire = range(order, len(rows))
    enter = {j for i in (*states, *wire) for j in wire if not _is_zero(rows[i][j])}
    leave = {i for i in wire for j in (*states, *wire) if not _is_zero(rows[i][j])}
    return Kept(tuple(states), tuple(sorted(place - order for place in enter & leave)))


def states_between(rows: MatrixRows, order: int) -> list[int]:
    """Return the states that the input reaches and that reach the output, by what is not exactly zero anywhere."""
    links = [(i, j) for i, row in enumerate(rows) for j, value in enumerate(row) if not _is_zero(value)]
    causes: dict[int, list[int]] = {}
    effects: dict[int, list[int]] = {}
    for effect, cause in links:
        effects.setdefault(cause, []).append(effect)
        causes.setdefault(effect, []).append(cause)
    inputs = range(order, len(rows[0]) if rows else order)
    outputs = range(order, len(rows))
    # inputs and outputs have the same numbers, but those are causes alone, and these effects alone
    forward = {state for state in _spread(effects, inputs, order) if state < order}
    return sorted(forward & {state for state in _spread(causes, outputs, order) if state < order})


def _spread(links: Mapping[int, Sequence[int]], ends: range, order: int) -> set[int]:
    first = {state for end in ends for state in links.get(end, ()) if state < order}
    within = {state: [other for other in links.get(state, ()) if other < order] for state in range(order)}
    return first | reached(within, first)


def _is_zero(value: Any) -> bool:
    if isinstance(value, Dual):
        return False
    return bool(value.arb.is_zero()) if isinstance(value, Ball) else value == 0.0


class ChangesLaterError(ModelError):
    """Error of what is not that of the start of the run later."""


def at_start(plan: Plan, ends: Ends, tick: int = 0) -> OrbitPoint:
    """Return the map between some ends at the start; raises `ChangesLaterError` where there is none."""
    try:
        return linearised(plan, tick).point_of(ends)
    except ModelError as error:
        raise ChangesLaterError(error.problems) from None


def changes_later(what: str, node: Endpoint, expected: str = "") -> Problem:
    """Return the problem of what is not that of the start of the run later."""
    return Problem(
        message=f"{what} changes after the start",
        key=".".join(node),
        expected=expected,
        hint="proofs are about the start of a run; `proofmass worst` searches at other operating points",
        path=("blocks", node[0]),
    )


def too_large(has: str, node: Endpoint, most: str, hint: str = "search with `proofmass worst`") -> Problem:
    """Return the problem of what has more states or values than matrices are met with."""
    return Problem(message=has, key=".".join(node), expected=f"at most {most}", hint=hint, path=("blocks", node[0]))


def _not_a_loop(node: Endpoint) -> Problem:
    signal = ".".join(node)
    message = f"what goes in at {signal} does not come back at the start of the run"
    return Problem(message=message, key=signal, path=("blocks", node[0]))
