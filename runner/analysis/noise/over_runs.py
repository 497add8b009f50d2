"""The standard deviation of one value over runs that differ in their random numbers: of an estimate, a result, a test.

A budget is that of an output that goes on for ever. A value at one time of a run, such as what a calibration has found
at its end, has a variance alone. It follows from all that happened since tick 0, by the exact derivatives along the run
without noise:

    P[n+1] = S P[n] S' + R V R'

P is the covariance of what lasts from tick to tick, S and R are its slopes by that and by new random numbers of the
variances V. Nothing need repeat or settle (Gelb, Applied Optimal Estimation, 1974, section 4.1).
"""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.blocks.declaration.units import short_unit
from proofmass.graphs.files.toml_reader import GraphSource
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.decisions.one_bit import noise_at
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints, linearised
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.linearisation.map_blocks import blocks_of_map
from proofmass.runner.analysis.noise.noise_map import variance
from proofmass.runner.derivatives.compact_ticks import EVERY, LIVE, CompactTicks, Direction
from proofmass.runner.derivatives.dual import plain, slopes_of
from proofmass.runner.derivatives.dual_noise import Noisy, NoisyTicks
from proofmass.runner.derivatives.dual_plan import SIGNALS
from proofmass.runner.host.arrays import Array
from proofmass.runner.host.notebook import Told
from proofmass.runner.host.progress import Progress
from proofmass.runner.plan.memory import Memory, Rows, start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan
from proofmass.runner.reference.interpret import TickError
from proofmass.runner.run.faults import failed

_SHOWN = 8  # times that the covariance moves on, for one look at progress


@dataclass(frozen=True, repr=False)
class ValueDeviation(Told):
    """Standard deviation over runs of one value of an output, and of the parts of it that each block makes.

    >>> from proofmass import deviation_over_runs, read_graph
    >>> last = deviation_over_runs(read_graph("library:recorded_motion"), "mean.mean", until="40 ms")
    >>> last.output, f"{last.deviation:.4f} {last.unit}"
    ('mean.mean', '0.0020 m/s^2')
    """

    output: str  # "block.port"
    unit: str  # of the output
    time: float  # seconds
    value: float  # there, without noise
    deviation: float  # over runs
    sources: Mapping[str, float]  # deviation by block, the largest first

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {
            "output": self.output,
            "unit": self.unit,
            "time_s": self.time,
            "value": self.value,
            "deviation": self.deviation,
            "sources": dict(self.sources),
        }


def deviation_over_runs(
    graph: GraphSource,
    output: str,
    *,
    until: str | float | Fraction | None = None,
    progress: Progress | None = None,
) -> ValueDeviation:
    """Return the standard deviation of an output at a time over runs of different seeds, exactly for small noise.

    `graph` runs from tick 0, and random numbers count from there; `output` is "block.port". The value is that of its
    last tick up to and with the time `until`, in seconds, which is the end of the graph's run unless said. Roundings
    count as in `noise`. Each tick is followed in Python, in some 1 ms; `progress` is called with the ticks that are
    done and all of them.

    Raises `ModelError` for a graph that cannot be linearised.

    >>> from proofmass import deviation_over_runs, read_graph
    >>> last = deviation_over_runs(read_graph("library:recorded_motion"), "mean.mean", until="40 ms")
    >>> list(last.sources)
    ['amplifier', 'gas', 'adc']
    """
    planned = plan(graph)
    ticks = planned.ticks() if until is None else OperatingPoints(planned, until).answered(lambda about: about.tick) + 1
    return deviations(planned, [output], ticks, progress)[0]


def deviations(
    planned: Plan, outputs: Sequence[str], ticks: int, progress: Progress | None = None
) -> list[ValueDeviation]:
    """Return those of the last values before a tick of several outputs."""
    nodes = [node_of(planned, output) for output in outputs]
    engine = followed(planned, nodes, ticks, {}, progress)
    early = next((output for output, node in zip(outputs, nodes, strict=True) if node not in engine.last), None)
    if early is not None:
        raise ModelError([planned.graph.placed(_early(early, (ticks - 1) * planned.period))])
    return [_deviation(planned, *each, engine.last[each[1]]) for each in zip(outputs, nodes, strict=True)]


def densities(
    planned: Plan, outputs: Sequence[str], ticks: int, window: Array
) -> list[tuple[ValueDeviation, Array, Array]]:
    """Return the deviations, frequencies and mean one-sided densities of the last values before a tick.

    There are as many of them as weights in the window. A line is the mean over runs of |sum of w y exp(-2 pi i f t)|^2.
    """
    nodes = [node_of(planned, output) for output in outputs]
    strides = {node: planned.stride(node) for node in nodes}
    # a value is recorded in each tick of its block from tick 0 on
    firsts = {node: -(-ticks // stride) - len(window) for node, stride in strides.items()}
    turns = np.arange(len(window) // 2 + 1) / len(window)
    stretches = {node: Stretch(window, firsts[node], turns) for node in nodes}
    engine = followed(planned, nodes, ticks, stretches)
    answers = []
    for output, node in zip(outputs, nodes, strict=True):
        rate = float(planned.schedule.base_rate) / strides[node]
        lines = np.arange(len(window) // 2 + 1) * rate / len(window)
        density = np.sum([*stretches[node].powers.values()], axis=0) * (2.0 / (rate * float(np.sum(window**2))))
        answers.append((_deviation(planned, output, node, engine.last[node]), lines, density))
    return answers


def _early(output: str, time: float) -> Problem:
    message, expected = f"{output} has no value before that time", "a time after its first tick"
    return Problem(message=message, key="until", got=f"{time:g} s", expected=expected, hint="name a later time")


def followed(
    planned: Plan,
    nodes: Sequence[Endpoint],
    ticks: int,
    stretches: "Mapping[Endpoint, Stretch]",
    progress: Progress | None = None,
    begin: Memory | None = None,
) -> "CovarianceTicks":
    """Return what a run up to a tick ends in, from a memory without noise or from tick 0; raises `ModelError`."""
    noisy = noise_at(linearised(planned), list(nodes))
    upstream, begin = blocks_of_map(planned, (), nodes, False, noisy)[0], begin or start(planned.without_noise)
    engine = CovarianceTicks(planned, begin, upstream, (), nodes, False, False, True, noise=noisy, stretches=stretches)
    first = begin.tick
    try:
        for done in range(first, ticks, _SHOWN * EVERY):
            if progress:
                progress(done - first, ticks - first)
            engine.advance(min(done + _SHOWN * EVERY, ticks), ())
    except TickError as error:
        raise ModelError([failed(planned, error)]) from error
    return engine


def _deviation(planned: Plan, output: str, node: Endpoint, last: "_Last") -> ValueDeviation:
    block = planned.blocks[node[0]]
    parts = sorted(((math.sqrt(v), name) for name, v in last.variances.items() if v > 0.0), reverse=True)
    return ValueDeviation(
        output=output,
        unit=short_unit(unit_of(block, type(block).outputs[node[1]])),
        time=planned.beat(node).at(last.number) * planned.period,
        value=last.value,
        deviation=math.sqrt(sum(last.variances.values())),
        sources={name: deviation for deviation, name in parts},
    )


@dataclass(frozen=True)
class _Last:
    """The last value of an output: its number from 0 on, and the variance that each block makes."""

    number: int
    value: float
    variances: Mapping[str, float]


class Stretch:
    """The mean power of the lines of some successive values, a sum Z of w y exp(-2 pi i f t) for each, by block.

    Z moves on as what lasts does, x: with y = s x + r u within some ticks, E[Z x'] and E[|Z|^2] follow. `turns` are the
    lines, in turns from value to value; `squares` are the sums of w^2 E[y^2] in each half of the window.
    """

    def __init__(self, window: Array, first: int, turns: Array) -> None:
        self.window, self._first, self._turns = window, first, turns
        self._shared: dict[str, Any] = {}  # E[Z x']
        self.powers, self.squares = dict[str, Array](), dict[str, Array]()

    def moved(self, number: int, slopes: "_Slopes", rows: range, covariances: Mapping[str, Array]) -> None:
        """Count values from a number on, some rows of slopes; the last of these are what lasts from now on."""
        numbers = np.arange(number, number + len(rows)) - self._first
        inside = (numbers >= 0) & (numbers < len(self.window))
        if not self._shared and not inside.any():
            return
        weights = np.where(inside, self.window[np.clip(numbers, 0, len(self.window) - 1)], 0.0)
        turns = np.exp(-2j * np.pi * np.outer(self._turns, numbers)) * weights
        own, after = slice(rows.start, rows.stop), slopes.memory
        early = 2 * numbers < len(self.window)
        halves = np.array([early, ~early]) * weights**2
        old = turns @ slopes.lasting[own]
        for name in {**covariances, **slopes.columns}:
            columns, covariance = slopes.columns.get(name, []), covariances.get(name)
            squares = np.diag(_moved(slopes, own, covariance, columns))
            self.squares[name] = self.squares.get(name, 0.0) + halves @ squares
            new = turns @ slopes.fresh[own, columns] if len(columns) else np.zeros((len(turns), 0))
            by = old @ covariance if covariance is not None else np.zeros_like(old)
            shared = self._shared.get(name, np.zeros_like(old))
            power = 2.0 * np.sum(old * shared.conj(), axis=1).real + np.sum(by * old.conj(), axis=1).real
            self.powers[name] = self.powers.get(name, 0.0) + power + np.sum(np.abs(new) ** 2, axis=1)
            self._shared[name] = (shared + by) @ slopes.lasting[after:].T + new @ slopes.fresh[after:, columns].T


@dataclass(frozen=True)
class _Slopes:
    """Slopes by what lasts, and by new random numbers times their deviations: of outputs, then of the memory."""

    lasting: Array
    fresh: Array
    columns: Mapping[str, list[int]]  # new random numbers of each block
    memory: int  # first row of the memory


class CovarianceTicks(CompactTicks):
    """Ticks that keep the covariance of what lasts, by the blocks that make it."""

    def __init__(self, *arguments: Any, noise: Noisy, stretches: Mapping[Endpoint, Stretch]) -> None:
        self._covariances: dict[str, Array] = {}
        self._alive = 0
        self._stretches, self._numbers = stretches, Counter[Endpoint]()
        self.last: dict[Endpoint, _Last] = {}
        super().__init__(*arguments, noise=noise)

    def advance(self, last: int, rows: Rows) -> bool:
        """Run up to, not including, the tick `last`; raises `TickError`."""
        while self._memory.tick < last:
            NoisyTicks.advance(self, min(self._memory.tick + EVERY, last), rows)
            self._gather()
        return True

    def _gather(self) -> None:
        """Give each number that lasts one direction, and move the covariances on."""
        recorded = {node: list(values) for node, values in self.recorded.items()}
        gathered = self._one_direction_each()
        outputs = [slopes_of(value, SIGNALS) for values in recorded.values() for value in values]
        slopes = self._slopes([*outputs, *gathered], len(outputs))
        self._keep(recorded, slopes)
        after = slopes.memory
        self._covariances = {
            name: _moved(slopes, slice(after, None), self._covariances.get(name), columns)
            for name, columns in self._by_block(slopes)
        }
        self._alive = len(gathered)
        done: list[Any] = [self.quantised, self.sources, self._known, self._counts, self._last]
        for each in [*done, *self.recorded.values()]:
            each.clear()

    def _keep(self, recorded: Mapping[Endpoint, list[Any]], slopes: _Slopes) -> None:
        """Keep the last value of each output with its variances, and count all in their stretches."""
        first = 0
        for node, values in recorded.items():
            rows, first = range(first, first + len(values)), first + len(values)
            if node in self._stretches:
                self._stretches[node].moved(self._numbers[node], slopes, rows, self._covariances)
            self._numbers[node] += len(values)
            if values:
                row = slice(rows[-1], rows[-1] + 1)
                variances = {
                    name: float(_moved(slopes, row, self._covariances.get(name), columns)[0, 0])
                    for name, columns in self._by_block(slopes)
                }
                self.last[node] = _Last(self._numbers[node] - 1, float(plain(values[-1])), variances)

    def _by_block(self, slopes: _Slopes) -> Iterator[tuple[str, list[int]]]:
        for name in {**self._covariances, **slopes.columns}:
            yield name, slopes.columns.get(name, [])

    def _slopes(self, rows: Sequence[Mapping[Direction, float]], memory: int) -> _Slopes:
        lasting = np.zeros((len(rows), self._alive))
        columns, owners = dict[Direction, int](), dict[str, list[int]]()
        new: list[tuple[int, int, float]] = []
        for row, each in enumerate(rows):
            for key, value in each.items():
                if key[1] == LIVE:
                    lasting[row, key[2]] = value
                    continue
                if key not in columns:
                    columns[key] = len(columns)
                    owners.setdefault(key[0], []).append(columns[key])
                new.append((row, columns[key], value * math.sqrt(variance(key[1]))))
        fresh = np.zeros((len(rows), len(columns)))
        for row, column, value in new:
            fresh[row, column] = value
        return _Slopes(lasting, fresh, owners, memory)


def _moved(slopes: _Slopes, rows: slice, covariance: Array | None, columns: list[int]) -> Array:
    """Return S P S' + R R' of some rows, for the random numbers in some columns."""
    lasting, fresh = slopes.lasting[rows], slopes.fresh[rows][:, columns]
    old = 0.0 if covariance is None else lasting @ covariance @ lasting.T
    return np.asarray(old + fresh @ fresh.T)
