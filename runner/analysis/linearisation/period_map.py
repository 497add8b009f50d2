"""The linear map of one common period of a graph: what a small change of states and inputs does, exactly.

    x[n+1] = A x[n] + B u[n] + step,   y[n] = C x[n] + D u[n] + level

x are deviations from an operating point. One period is the least time after which all blocks tick
together again; u and y hold an entry for each tick of their wires in it (lifting: Meyer and Burrus,
IEEE Trans. Circuits and Systems 22, 1975, 162).
"""

from collections import defaultdict
from collections.abc import Callable, Collection, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from proofmass.blocks.arithmetic.mantissa import Drop
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.map_blocks import (
    MOST_VALUES,
    blocks_of_map,
    not_linear,
    period_of_blocks,
    too_many,
)
from proofmass.runner.analysis.linearisation.rings import Entry, Rings
from proofmass.runner.analysis.linearisation.seeds import (
    NO_RINGS,
    PointSlopes,
    held_in,
    place_of,
    seed,
    seed_wires,
    with_slopes,
    without_slopes,
)
from proofmass.runner.analysis.linearisation.tick_maps import TickMaps, between, maps_of_ticks, reached
from proofmass.runner.derivatives.compact_ticks import CompactTicks, InFirst
from proofmass.runner.derivatives.dual import NO_SLOPE, SIGNALS, plain, slopes_of, value_of
from proofmass.runner.derivatives.dual_noise import NOTHING, Followed, Noisy, NoisyTicks, one_model_each
from proofmass.runner.derivatives.dual_plan import differentiated
from proofmass.runner.derivatives.dual_ticks import DualTicks, LastingPlace
from proofmass.runner.derivatives.stepped_ticks import Indices, SteppedTicks, UndefinedSlopesError
from proofmass.runner.host.arrays import Array, Truths
from proofmass.runner.plan.memory import Memory, start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.interpret import TickError

if TYPE_CHECKING:
    from proofmass.runner.targets.native_noise import CompiledNoise
    from proofmass.runner.targets.native_slopes import CompiledSlopes, SlopeCode

_MANY = 64  # from so many base ticks on the directions of noise are compressed


class UnrepeatedError(ModelError):
    """The orbit of a graph does not come back in any period that a map can cover: noise is that along its run."""


@dataclass(frozen=True, eq=False)
class PeriodMap:
    """Rows [A B step] and below them [C D level]; `slopes` are the derivatives of it all by each parameter."""

    states: tuple[Entry, ...]
    inputs: tuple[Entry, ...]
    outputs: tuple[Entry, ...]
    matrix: Array
    slopes: Mapping[str, Array]
    period: float  # seconds
    tick: int = 0  # of the operating point, in base ticks
    time: float = 0.0  # the same in seconds
    undefined: tuple[str, ...] = ()  # parameters without a finite derivative
    notes: tuple[str, ...] = ()  # on the operating point
    later: "tuple[PeriodMap, ...]" = ()  # maps of later periods, where they differ
    others: "tuple[PeriodMap, ...]" = ()  # of other stretches or instants of an orbit that does not come back
    point: tuple[float, ...] = ()  # values of the states there
    end: Memory | None = None  # after the period, in plain numbers
    told: str = ""  # how the operating point was found
    starting: bool = False  # whether the map changes after a start
    rounded: bool = False  # whether numbers are those of a run, else what they were without rounding
    drops: Mapping[Entry, Drop] = field(default_factory=dict)  # of roundings in fixed point
    late: float = 0.0  # seconds from the first value of the only input to that of the only output
    ticks: TickMaps | None = None  # of a loop, from value to value of the wire

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.states)

    def names(self, entries: Sequence[Entry]) -> list[str]:
        """Names of states, inputs or outputs; those of a wire have numbers if several."""
        several = {entry[:2] for entry in entries if entry[2] > 0}
        return [f"{name}.{part}" + (f"[{i}]" if (name, part) in several else "") for name, part, i in entries]

    def parts(self, of: Array | None = None) -> tuple[Array, Array, Array, Array]:
        """A, B, C and D of the map, or of one of its slopes."""
        matrix, n = self.matrix if of is None else of, self.order
        return matrix[:n, :n], matrix[:n, n:-1], matrix[n:, :n], matrix[n:, n:-1]

    def kept(self, states: Sequence[int]) -> "PeriodMap":
        """The map with these states alone."""
        return self.part(states, range(len(self.outputs)), range(len(self.inputs)))

    def to_outputs(self, outputs: Sequence[int]) -> "PeriodMap":
        """Return the map to these outputs alone."""
        return self.part(range(self.order), outputs, range(len(self.inputs)))

    def part(self, states: Sequence[int], outputs: Sequence[int], inputs: Sequence[int]) -> "PeriodMap":
        """Return the map with these states, outputs and inputs alone."""
        n = self.order
        rows = np.array([*states, *(n + i for i in outputs)], dtype=np.int64)
        columns = np.array([*states, *(n + i for i in inputs), self.matrix.shape[1] - 1], dtype=np.int64)
        kept = tuple(self.states[i] for i in states)
        ticks = self.ticks if self.ticks and self.ticks.places.keys() >= {*kept} else None
        return replace(
            self,
            states=kept,
            inputs=tuple(self.inputs[i] for i in inputs),
            outputs=tuple(self.outputs[i] for i in outputs),
            matrix=_taken(self.matrix, rows, columns),
            slopes={name: _taken(slope, rows, columns) for name, slope in self.slopes.items()},
            point=tuple(self.point[i] for i in states) if self.point else (),
            ticks=ticks,
        )

    def along(self, parameter: str, step: float) -> "PeriodMap":
        """Return the map whose matrices have gone a step along their derivatives by a parameter."""
        return replace(self, matrix=self.matrix + step * self.slopes[parameter], ticks=None)

    def with_slopes(self, moved: "PeriodMap") -> "PeriodMap":
        """Return the map with the slopes of one by parameters, whose numbers are not rounded."""
        n, m, states = self.order, moved.order, _places(self.states, moved.states)
        held = len(moved.inputs) // len(self.inputs) if self.ticks else 1
        rows = np.array([*states, *(m + _places(self.outputs, moved.outputs, held))])
        enter = np.zeros((moved.matrix.shape[1], self.matrix.shape[1]))
        for later in range(held):
            enter[m + later + _places(self.inputs, moved.inputs, held), n + np.arange(len(self.inputs))] = 1.0
        enter[states, np.arange(n)] = enter[-1, -1] = 1.0
        slopes = {name: slope[rows] @ enter for name, slope in moved.slopes.items()}
        return replace(self, slopes=slopes, undefined=moved.undefined)

    def between(self) -> "PeriodMap":
        """The map without states that no input reaches, or that reach no output: counters, noise, coefficients."""
        return self.kept(self._between)

    def moved_between(self) -> Array:
        """A of these states alone."""
        return self.matrix[np.ix_(self._between, self._between)]

    @cached_property
    def _between(self) -> list[int]:
        return between(*self._edges)

    def between_with(self, other: "PeriodMap") -> list[int]:
        """Return the states that lie between inputs and outputs in this period or in that of another map.

        All cells of a buffer count as one: a later period may read what an earlier one wrote.
        """
        acts, entered, read = (one | two for one, two in zip(self._edges, other._edges, strict=True))
        buffers: dict[tuple[str, str], list[int]] = {}
        for place, (name, buffer, number) in enumerate(self.states):
            if number >= 0:
                buffers.setdefault((name, buffer), []).append(place)
        for cells in buffers.values():
            acts[np.ix_(cells, cells)] = True
        return between(acts, entered, read)

    def moving(self) -> list[int]:
        """Return the states that a period does not leave as they are, whatever the parameters."""
        n = self.order
        moving = (self.matrix[:n] != np.eye(n, self.matrix.shape[1])).any(axis=1)
        for slope in self.slopes.values():
            moving |= slope[:n].any(axis=1)
        return np.flatnonzero(moving).tolist()

    def seen(self) -> "PeriodMap":
        """The map without states that reach no output."""
        acts, _, read = self._edges
        return self.kept(np.flatnonzero(reached(acts, read)).tolist())

    @cached_property
    def _edges(self) -> tuple[Truths, Truths, Truths]:
        """States that each state depends on, a row each, those that inputs enter, and those that outputs read."""
        pattern, n = self.matrix != 0.0, self.order
        for slope in self.slopes.values():
            pattern = pattern | (slope != 0.0)
        return pattern[:n, :n], pattern[:n, n:-1].any(axis=1), pattern[n:, :n].any(axis=0)


def _taken(matrix: Array, rows: Indices, columns: Indices) -> Array:
    """Return a matrix of these rows and columns: one after the other take a fifth of the time; all of them, none."""
    for axis, places in enumerate((rows, columns)):
        if not np.array_equal(places, np.arange(matrix.shape[axis])):
            matrix = np.take(matrix, places, axis=axis)
    return matrix


def _places(entries: Sequence[Entry], among: Sequence[Entry], held: int = 1) -> Indices:
    """Return the places of entries among others, of which each is held for several."""
    places = {entry: place for place, entry in enumerate(among)}
    return np.array([places[name, part, number * held] for name, part, number in entries], dtype=np.int64)


def period_map(
    plan: Plan,
    inputs: Sequence[Endpoint],
    outputs: Sequence[Endpoint],
    *,
    cut: bool = False,
    everything: bool = False,
    by_parameters: bool = False,
    by_ticks: bool = True,
    noise: Noisy = NOTHING,
    memory: Memory | None = None,
    periods: int = 1,
    rings: Rings = NO_RINGS,
    point_slopes: PointSlopes | None = None,
    span: int = 0,
    integrated: bool = False,
    drawn: bool = False,
    quantisers: Collection[str] = (),
    slopes: "Callable[[int, bool, AbstractSet[str]], SlopeCode | None]" = lambda ticks, noise, blocks: None,
    later: Callable[[Memory, int], Memory] | None = None,
    opened: "Callable[[SlopeCode, Memory, int, AbstractSet[LastingPlace]], CompiledSlopes | None] | None" = None,
) -> PeriodMap:
    """Linearise what lies between some wires, from a memory on, or from tick 0.

    The map covers this many common `periods`, or `span` base ticks. Buffers that are `rings` count
    from their places. `point_slopes` are the derivatives of the memory there `by_parameters`.
    Without them, memory that still has its start value has the derivatives of that. The map of a
    loop through one wire is made `by_ticks`, of the states that lie in the loop alone, where it can
    be. With `integrated` continuous groups move as in a run, and are linearised along the way
    within each tick.

    `inputs` are added to the signals of their wires, or replace them if `cut`. States are those of
    blocks on paths from inputs to outputs, or of `everything` that the outputs depend on. Of blocks
    with `noise` the deviates and the errors of quantisers are further inputs, what some
    `quantisers` are given is a further output (`NoisyTicks`), and the states are those of blocks on
    paths from there too. With `drawn` that is along a run with noise. `slopes` returns the machine
    code of ticks with their slopes, if the plan has such, for long periods. With `later`, which
    runs a memory on by some ticks, a wire that holds its value counts once, where all of its values
    are held alike. The map then begins with a new value. `opened` returns the slopes of ticks of a
    loop, if they were taken with those of others.

    Raises `ModelError` that names the block that cannot be linearised.
    """
    heard = [*outputs, *((name, "") for name in quantisers)]
    upstream, moving = blocks_of_map(plan, inputs, heard, everything, noise)
    holding = moving | {name for name, _ in inputs}  # slower inputs last from tick to tick, too
    ticks = span or period_of_blocks(plan, moving, [*inputs, *outputs]) * periods
    memory = memory or start(plan)
    if by_parameters:
        plan = differentiated(plan)
    quiet = plan if noise else plan.without_noise
    counted: set[str] = set()  # blocks whose integers are bits or indices and keep their values
    single = by_ticks and cut and len(inputs) == 1 and not by_parameters and not noise
    stepped = single and ticks > min(plan.stride(inputs[0]), _MANY)
    coded = not by_parameters and one_model_each(noise)
    code = slopes(ticks, bool(noise), upstream) if coded else None
    if code is not None and not code.wires.keys() >= {*inputs, *outputs}:  # vectors, truth values
        code = None
    while True:
        begin = with_slopes(memory, plan, point_slopes, rings) if by_parameters else memory.copy()
        seeded = seed(plan, begin, sorted(moving), counted, rings)
        seeded += seed_wires(plan, begin, holding)
        values = [held_in(begin, entry, rings) for entry in seeded]
        given = plan, begin, upstream, inputs, outputs, cut, by_parameters, integrated
        engine: DualTicks | CompiledSlopes | CompiledNoise
        in_code: CompiledNoise | None = None
        starts = {entry: place_of(memory, entry, rings) for entry in seeded}
        if code is not None and not single:
            followed = Followed(upstream, holding, inputs, outputs, noise, drawn, quantisers, cut)
            # start-up time: short periods need no compiler
            from proofmass.runner.targets import native_noise

            engine = in_code = native_noise.CompiledNoise(code, code.of(quiet), memory, followed, {*starts.values()})
        elif noise:
            many = ticks > _MANY and not by_parameters
            engine = (CompactTicks if many else NoisyTicks)(*given, noise=noise, drawn=drawn, quantisers=quantisers)
        elif code is not None:
            shared = None if counted or opened is None else opened(code, memory, ticks, {*starts.values()})
            engine = shared or code.ticks(memory, inputs, {*starts.values()}, moving, code.of(quiet))
        else:
            engine = (SteppedTicks if stepped else DualTicks)(*given)
        try:
            if not engine.advance(begin.tick + ticks, ()):
                code = None  # plain Python says what has failed
                continue
        except UndefinedSlopesError as error:
            bits = {name for name in error.blocks if name not in counted}
            counted |= bits
            code = code if bits else None
            continue
        except TickError as error:
            name = error.at.rpartition(".")[0]
            if name in counted or name not in moving:
                raise plan.graph.placed(not_linear(error.at, str(error.value))).error from error
            counted.add(name)
            continue
        maps, each = None, 1
        if not (in_code or isinstance(engine, DualTicks)) or isinstance(engine, SteppedTicks):
            end = engine.memory()
            ends = {entry: place for entry in seeded if (place := place_of(end, entry, rings)) in engine.live}
            maps = maps_of_ticks(engine.slopes(), starts, ends)  # type: ignore[union-attr]
            first, each = maps.holds() if maps and later else (0, 1)
            if first and later:
                memory = later(memory, first * plan.stride(inputs[0]))
                continue
            maps = maps.held(each) if maps and each > 1 else maps
        values_of_wire = len(maps.d) if maps else 0
        if values_of_wire > MOST_VALUES or (code is not None and maps is None and in_code is None):
            number = values_of_wire or ticks // plan.stride(inputs[0])
            raise plan.graph.placed(too_many(inputs[0], number)).error
        if stepped and maps is None:
            stepped = False
            continue
        return replace(
            _read(
                engine, starts, values, inputs, outputs, ticks * plan.period, rings, in_code, maps, each, by_parameters
            ),
            tick=memory.tick,
            time=memory.tick * plan.period,
            end=without_slopes(engine.memory(), plan),
            rounded=in_code is not None,
            drops=engine.drops,
            late=late_by(plan, inputs[0], outputs[0]) if len(inputs) == len(outputs) == 1 else 0.0,
        )


def late_by(plan: Plan, input: Endpoint, output: Endpoint) -> float:
    """Return the seconds from the first value of an input to that of an output, by clock offsets."""
    return (plan.beat(output).phase - plan.beat(input).phase) * plan.period


def _read(
    engine: "DualTicks | CompiledSlopes | CompiledNoise",
    starts: Mapping[Entry, LastingPlace],
    values: list[Any],
    inputs: Sequence[Endpoint],
    outputs: Sequence[Endpoint],
    period: float,
    rings: Rings,
    in_code: "CompiledNoise | None" = None,
    ticks: TickMaps | None = None,
    each: int = 1,
    by_parameters: bool = False,
) -> PeriodMap:
    """The map from what the dual numbers are after a period, or from the maps of its ticks; a value is held `each`."""
    seeded, memory = [*starts], engine.memory()
    recorded = {node: of_wire[::each] for node, of_wire in engine.recorded.items()}
    rows = [held_in(memory, entry, rings) for entry in seeded]
    rows += [value for node in outputs for value in recorded[node]]
    rows += engine.quantised.values()
    order = {node: number for number, node in enumerate(inputs)}
    injected = sorted(engine.injected, key=lambda key: (order[key[:2]], key[2]))
    injected = injected[: len(injected) // each] + sorted(engine.sources)
    columns = {key: number for number, key in enumerate([*seeded, *injected])}
    matrix = np.zeros((len(rows), len(columns) + 1))
    slopes = defaultdict[str, Array](lambda: np.zeros_like(matrix))

    def put(row: int, column: int, number: Any, less: Any = 0.0) -> None:
        if not by_parameters:
            matrix[row, column] = plain(number) - plain(less)
            return
        matrix[row, column] = value_of(number) - value_of(less)
        for name, slope in slopes_of(number - less).items():
            slopes[str(name)][row, column] = slope

    places = np.zeros(0, dtype=np.int64)  # of first directions
    for row, value in enumerate(rows):
        before = values[row] if row < len(seeded) else 0.0
        put(row, -1, value_of(value, SIGNALS), value_of(before, SIGNALS))
        if isinstance(value, InFirst):
            if len(places) < len(value.row):
                places = np.array([columns[key] for key in value.columns])
            matrix[row, places[: len(value.row)]] = value.row
            continue
        for key, slope in () if ticks else slopes_of(value, SIGNALS).items():
            put(row, columns[key], slope)
    if in_code:
        ends = [place_of(memory, entry, rings) for entry in seeded]
        in_code.put(matrix[:, :-1], ends, [*starts.values()], injected)
    if ticks:
        own = [*(columns[entry] for entry in ticks.places), *range(len(seeded), len(rows))]
        matrix[np.ix_(own, own)] = ticks.lifted([*ticks.places])
    for row in map(int, np.flatnonzero(~np.isfinite(matrix).all(axis=1))):
        at = ".".join(seeded[row][:2] if row < len(seeded) else outputs[0])
        raise engine.plan.graph.placed(not_linear(at, NO_SLOPE)).error
    made = tuple((*node, number) for node in outputs for number in range(len(recorded[node])))
    made += tuple(engine.quantised)
    undefined = tuple(sorted(name for name, slope in slopes.items() if not np.isfinite(slope).all()))
    defined = {name: slope for name, slope in slopes.items() if name not in undefined}
    point = tuple(float(value_of(value)) for value in values)
    return PeriodMap(
        tuple(seeded), tuple(injected), made, matrix, defined, period, undefined=undefined, point=point, ticks=ticks
    )
