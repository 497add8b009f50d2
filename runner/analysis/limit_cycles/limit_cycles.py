"""Limit cycles of a loop with one nonlinear block: predicted by its describing function, and as simulated.

    N(A) L(j w) = -1

L is the rest of the loop, linearised with the block as a gain of one. In a sampled loop w goes to
half the rate, where a sampled sine is +-A, so that the fundamental of a relay is its output itself:
N(A) = y(A) / A.
"""

import cmath
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import scipy.optimize

from proofmass.blocks.declaration.instance import unit_of
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Graph, Probe
from proofmass.runner.analysis.limit_cycles.describing import Describing
from proofmass.runner.analysis.limit_cycles.quasi_linear import describing_of, ends, replaced
from proofmass.runner.analysis.linearisation.linearisation import linearised
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.margins.frequencies import sweep
from proofmass.runner.host.arrays import Array, Complex
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.simulate import simulate

_AMPLITUDES = np.geomspace(1e-9, 1e9, 1801)  # to try
PERIODS = 200  # of a simulated limit cycle
_LASTING = 0.1  # of its swing: a change over a quarter of the run by which it has not come about yet, or decays
_brentq: Any = scipy.optimize.brentq


@dataclass(frozen=True)
class LimitCycle:
    """An oscillation at the input of a block: its amplitude in the input's unit, its frequency."""

    amplitude: float
    frequency: float  # Hz

    def as_data(self) -> dict[str, float]:
        """The numbers by name."""
        return asdict(self)


def predicted(graph: Graph, name: str) -> list[LimitCycle]:
    """Return the limit cycles that the describing function of a block predicts, slowest first; raises `ModelError`."""
    flat = flatten(graph)
    describing = describing_of(flat, name)
    linear = plan(replaced(flat, {name: 1.0}))
    system = linearised(linear).loop((name, "output"))
    w = sweep(system)
    cycles = []
    for branch in _branches(describing):
        cycles += list(_crossed(system, w, branch))
    if not system.continuous:
        cycles += list(_at_half_the_rate(system, describing))
    apart: list[LimitCycle] = []
    for cycle in sorted(cycles, key=lambda cycle: (cycle.frequency, cycle.amplitude)):
        if not apart or not _alike(cycle, apart[-1]):
            apart.append(cycle)
    return apart


def amplitude_unit(graph: Graph, name: str) -> str:
    """Return the unit of the amplitudes."""
    flat = flatten(graph)
    block = flat.blocks[name]
    return unit_of(block, type(block).inputs[ends(flat, name)[0]])


def simulated(graph: Graph, name: str, cycles: Sequence[LimitCycle] | None = None) -> LimitCycle | None:
    """Return the limit cycle of a run: the fundamental at the input of a block in its second half;
    None if that is at rest, or still grows or decays.

    The run starts at tick 0. It lasts as long as the graph says, or for `PERIODS` of the slowest
    predicted cycle.
    """

    flat = flatten(graph)
    entry, _ = ends(flat, name)
    source = next(wire.source for wire in flat.wires if wire.target == f"{name}.{entry}")
    lone = flat.as_graph().bare(probes=(Probe(source),))
    slowest = min((cycle.frequency for cycle in cycles or ()), default=1.0)
    trace = simulate(lone, duration=None if cycles is None else f"{PERIODS / slowest} s")[source]
    values, times = np.asarray(trace.values, dtype=float), np.asarray(trace.times, dtype=float)
    later = values[len(values) // 2 :]
    return _fundamental(times[len(times) // 2 :], later) if _lasts(later) else None


def _lasts(values: Array) -> bool:
    """Return whether a signal swings as far in its second half as in its first."""
    early, late = (float(np.ptp(part)) for part in np.array_split(values, 2)) if len(values) > 1 else (0.0, 0.0)
    return abs(late - early) <= _LASTING * early


def _fundamental(times: Array, values: Array) -> LimitCycle | None:
    """Return the frequency of a signal and its fundamental's amplitude, over all whole cycles."""
    middle = 0.5 * (values.max() + values.min()) if len(values) else 0.0
    swing = values - middle
    up = np.flatnonzero((swing[:-1] < 0.0) & (swing[1:] >= 0.0))
    if len(up) < 2:
        return None
    crossed = times[up] + (times[up + 1] - times[up]) * -swing[up] / (swing[up + 1] - swing[up])
    frequency = (len(crossed) - 1) / float(crossed[-1] - crossed[0])
    whole = slice(int(up[0]) + 1, int(up[-1]) + 1)
    turn = np.exp(-2j * math.pi * frequency * times[whole])
    half = abs(frequency * 2.0 * (times[1] - times[0]) - 1.0) < 1e-9
    amplitude = abs(complex(np.mean(swing[whole] * turn))) * (1.0 if half else 2.0)
    return LimitCycle(amplitude, frequency)


@dataclass(frozen=True)
class _Branch:
    """A range of amplitudes in which |N| is monotonic, so that it takes each value once."""

    describing: Describing
    amplitudes: Array
    values: Complex

    def amplitude(self, size: float) -> float | None:
        """Return the amplitude at which |N| has this size."""
        apart = np.abs(self.values) - size
        at = np.flatnonzero(apart[:-1] * apart[1:] <= 0.0)
        if not len(at):
            return None
        low, high = (math.log(float(v)) for v in self.amplitudes[at[0] : at[0] + 2])
        ends = [abs(self.describing(math.exp(x))) - size for x in (low, high)]
        if ends[0] * ends[1] > 0.0:  # but for the rounding of the logarithm
            return float(self.amplitudes[at[0] + int(abs(ends[1]) < abs(ends[0]))])
        return float(math.exp(_brentq(lambda x: abs(self.describing(math.exp(x))) - size, low, high)))

    def angles(self, sizes: Array) -> Array:
        """Return arg N at the amplitudes where |N| has these sizes, by interpolation; NaN where it never has."""
        order = np.argsort(np.abs(self.values))
        known = np.log(np.abs(self.values[order]))
        return np.interp(np.log(sizes), known, np.angle(self.values[order]), left=np.nan, right=np.nan)


def _branches(describing: Describing) -> Iterator[_Branch]:
    values = np.array([describing(float(a)) for a in _AMPLITUDES], dtype=complex)
    nonzero = np.flatnonzero(np.abs(values) > 0.0)
    sizes = np.abs(values[nonzero])
    steps = np.sign(np.round(np.diff(sizes) / sizes[:-1], 12))
    begin = 0
    for i in range(1, len(steps) + 1):
        if i == len(steps) or steps[i] != steps[begin]:
            if steps[begin]:
                kept = nonzero[begin : i + 1]
                yield _Branch(describing, _AMPLITUDES[kept], values[kept])
            begin = i


def _crossed(system: OpenLoop, w: Array, branch: _Branch) -> Iterator[LimitCycle]:
    """Yield the cycles where the phase of N L is -180 deg, and the amplitude of size 1."""
    response = system.response(w)
    with np.errstate(divide="ignore"):
        turns = np.angle(-response) + branch.angles(1.0 / np.abs(response))
    turns = (turns + math.pi) % (2.0 * math.pi) - math.pi

    def phase(at: float) -> float:
        value = complex(system.response(at))
        amplitude = branch.amplitude(1.0 / abs(value))
        return math.nan if amplitude is None else cmath.phase(-branch.describing(amplitude) * value)

    for i in np.flatnonzero((turns[:-1] * turns[1:] <= 0.0) & (np.abs(np.diff(turns)) < 1.0)):
        low, high = float(w[i]), float(w[i + 1])
        if not phase(low) * phase(high) <= 0.0:
            continue
        at = float(_brentq(phase, low, high, xtol=1e-14, rtol=1e-12))
        amplitude = branch.amplitude(1.0 / abs(complex(system.response(at))))
        if amplitude is not None:
            yield LimitCycle(amplitude, at / (2.0 * math.pi))


def _at_half_the_rate(system: OpenLoop, describing: Describing) -> Iterator[LimitCycle]:
    """Yield the cycle of two samples of a relay: the fundamental of +-y is y, not 4 y / pi."""
    w = math.pi / system.sample
    value = complex(system.response(w)).real
    if value >= 0.0 or not math.isfinite(value):
        return
    size = abs(describing(1.0)) * math.pi / 4.0  # of a relay; others have their own cycles below half the rate
    alike = abs(describing(7.0)) * 7.0 * math.pi / 4.0
    if abs(alike - size) < 1e-9 * size:
        yield LimitCycle(-size * value, 0.5 / system.sample)


def _alike(first: LimitCycle, second: LimitCycle) -> bool:
    return abs(first.frequency - second.frequency) < 1e-6 * first.frequency and (
        abs(first.amplitude - second.amplitude) < 1e-6 * first.amplitude
    )
