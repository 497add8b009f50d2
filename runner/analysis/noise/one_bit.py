"""Gains of quantisers of one bit, from a run: v = K y + e with the K that makes the mean of e^2 least.

    K = E[y v] / E[y^2],   var e = E[v^2] - K^2 E[y^2]

without the means of y and v (Booton, IRE Trans. Circuit Theory 1, 1954, 9; Ardalan and Paulos, IEEE Trans. Circuits and
Systems 34, 1987, 593). e is uncorrelated with y, and counts as white. For a Gaussian y and levels of +-1 both have a
closed form, K = sqrt(2 / pi) exp(-erfinv(m)^2) / sigma about a mean level m. What integrators hold is not Gaussian, so
that it would be wrong by some dB: the moments are those of a run of the graph with its noise.
"""

from collections.abc import Callable
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.digraph import reached
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.forward import memory_at
from proofmass.runner.analysis.linearisation.period_map import Array, blocks_of_map, plan_graph
from proofmass.runner.analysis.linearisation.periodic import PeriodicPoint, Point
from proofmass.runner.derivatives.dual_functions import LEVELS, compared, reaches, with_functions
from proofmass.runner.derivatives.dual_noise import Gain, Noisy
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.interpret import Interpreter, TickError
from proofmass.runner.run.faults import failed

DECISIONS, SETTLING = 16_384, 2_048  # of a quantiser that are counted, and before them
_MOST_CALLS = 4_000_000  # of functions of blocks
_WINDOW = 256  # decisions over which signals count as constant: their means are subtracted
_LAGS = 64  # most decisions after which an error may repeat
_LONG, _LOW = 2048, slice(4, 24)  # decisions of a segment, and its lines at low frequencies
COLOURED = 1.0  # dB by which the density at low frequencies may differ without a note
REPEATS = 0.2  # autocorrelation of the error from which on it is not white


@dataclass(frozen=True)
class OneBit(Gain):
    """Gain and error of a quantiser of one bit, as a run shows them."""

    mean: float  # of its levels
    decisions: int
    correlation: float  # the largest of e with itself
    lag: int  # decisions after which the correlation is reached
    low: float  # dB, density of e from 0.2 % to 1.2 % of the rate against that of white noise

    def note(self, block: str) -> str:
        """Return what is said of it in a budget."""
        told = f"{block}: one bit counts as a gain of {self.gain:.3g}, by a run of {self.decisions:,} decisions"
        if abs(self.low) > COLOURED:
            told += (
                f"; from 0.2 % to 1.2 % of its rate its error has {self.low:+.1f} dB against white noise, left out here"
            )
        if abs(self.correlation) < REPEATS:
            return told
        after = "from one to the next" if self.lag == 1 else f"after {self.lag} of them"
        return (
            f"{told}; its error is not white, with a correlation of {self.correlation:.2f} {after}: its density"
            " has tones, and holds as a mean over wide bands"
        )


def with_gains(plan: Plan, noise: Noisy, outputs: list[Endpoint], point: Point) -> Noisy:
    """Return the blocks with noise, with the gains of one-bit quantisers in loops upstream of some outputs."""
    upstream = blocks_of_map(plan, (), outputs, False, noise)[0]
    deciding = _deciding(plan, upstream, outputs)
    if not deciding:
        return noise
    begin = point.memory if isinstance(point, PeriodicPoint) else memory_at(plan.without_noise, point)
    decisions = _Decisions(plan, begin.copy(), upstream, deciding)
    try:
        records = decisions.taken()
    except TickError as error:
        raise ModelError([failed(plan, error)]) from error
    found = {name: tuple(map(_one_bit, several)) for name, several in records.items()}
    return dict(sorted({**noise, **found}.items()))


def _deciding(plan: Plan, upstream: AbstractSet[str], outputs: list[Endpoint]) -> set[str]:
    """Return the blocks in loops that choose one of some levels."""
    wiring, read = plan_graph(plan), {*plan.schedule.drivers.values(), *outputs}
    deciding = set[str]()
    for name in upstream:
        kind = type(plan.blocks[name])
        own = "update" in kind.functions and reaches(kind.functions["update"].function, LEVELS)
        ports = [port for port, behaviour in kind.output_functions.items() if reaches(behaviour.function, LEVELS)]
        looped = any((name, port) in read for port in ports) and name in reached(wiring, {name})
        if own or looped:
            deciding.add(name)
    return deciding


class _Decisions(Interpreter):
    """A run with noise that notes what quantisers of one bit are given, and the levels that they choose."""

    def __init__(self, plan: Plan, memory: Memory, upstream: AbstractSet[str], deciding: AbstractSet[str]) -> None:
        self._deciding, self._owner = deciding, ""
        self._several: dict[str, list[list[tuple[float, float]]]] = {}
        self._seen: dict[str, tuple[int, list[float]]] = {}
        solvers = tuple(solver for solver in plan.solvers if not upstream.isdisjoint(solver.group.blocks))
        super().__init__(replace(plan, solvers=solvers, probes=()), plan.graph.seed, memory=memory)
        self._outputs = [each for each in self._outputs if each[0][0] in upstream]
        self._updates = [update for update in self._updates if update[0] in upstream]

    def taken(self) -> dict[str, list[Array]]:
        """Return input and level of each decision, a row each: of each block those of its quantisers of one bit."""
        common = max(self.filled.schedule.divisors[name] for name in self._deciding)
        self.advance(self._memory.tick + common, ())
        own = [self.filled.schedule.divisors[name] for name in self._several]
        if not own:  # all have more levels
            return {}
        calls = max(1, len(self._outputs) + len(self._updates))
        ticks = min((DECISIONS + SETTLING) * max(own), _MOST_CALLS // calls)
        first = ticks * SETTLING // (DECISIONS + SETTLING)
        self.advance(self._memory.tick + first, ())
        for several in self._several.values():
            for decisions in several:
                decisions.clear()
        self.advance(self._memory.tick + ticks - first, ())
        return {name: [np.array(each) for each in several if each] for name, several in self._several.items()}

    def _bound(self, name: str, function: str) -> Callable[[int], Any]:
        self._owner = name
        return super()._bound(name, function)

    def _callable(self, block: Block, behaviour: Behaviour) -> Callable[..., Any]:
        if self._owner not in self._deciding:
            return super()._callable(block, behaviour)
        return with_functions(behaviour.function, {rule: self._noting(self._owner, rule) for rule in LEVELS})

    def _noting(self, owner: str, rule: Callable[..., Any]) -> Callable[[Any, Any], Any]:
        def decide(first: Any, second: Any) -> Any:
            level, value = rule(first, second), compared(rule, first, second)
            if value is second or second == 1.0:
                self._note(owner, value, float(level))
            return level

        return decide

    def _note(self, owner: str, value: float, level: float) -> None:
        tick, known = self._seen.get(owner, (-1, []))
        if tick != self._memory.tick:
            known = []
            self._seen[owner] = self._memory.tick, known
        if value in known:
            return
        known.append(value)
        several = self._several.setdefault(owner, [])
        if len(several) < len(known):
            several.append([])
        several[len(known) - 1].append((value, level))


def _one_bit(decisions: Array) -> OneBit:
    """Return the gain that comes closest to the decisions, and how white what is left is."""
    whole = len(decisions) // _WINDOW * _WINDOW or len(decisions)
    mean = float(decisions[:, 1].mean())
    windows = decisions[:whole].reshape(-1, min(_WINDOW, whole), 2)
    moving = windows - windows.mean(axis=1, keepdims=True)
    lost = moving.shape[1] / max(moving.shape[1] - 1, 1)
    y, v = moving[..., 0], moving[..., 1]
    power = float(np.mean(y**2))
    gain = float(np.mean(y * v)) / power if power else 0.0
    e = v - gain * y
    variance = float(np.mean(e**2))
    lags = range(1, min(_LAGS, moving.shape[1] - 1) + 1)
    known = [float(np.mean(e[:, lag:] * e[:, :-lag])) / variance if variance else 0.0 for lag in lags]
    lag = int(np.argmax(np.abs(known))) if known else 0
    low = _low(decisions - decisions.mean(axis=0), gain, variance)
    return OneBit(gain, variance * lost, mean, whole, known[lag] if known else 0.0, lag + 1, low)


def _low(decisions: Array, gain: float, variance: float) -> float:
    """Return the density of the error at low frequencies against its mean density, in dB."""
    count = len(decisions) // _LONG
    if not count or not variance:
        return 0.0
    e = (decisions[:, 1] - gain * decisions[:, 0])[: count * _LONG].reshape(count, _LONG)
    window = np.hanning(_LONG)
    lines = np.abs(np.fft.rfft(e * window, axis=1)) ** 2 / np.sum(window**2)
    return float(10.0 * np.log10(np.mean(lines[:, _LOW]) / variance + 1e-30))
