"""Quantisers of one bit in a budget: v = K y + e, with K and the spectrum of e from two runs of the graph.

The runs have different noise. Half the power of what they differ by is that of the noise, without
signals, and without what repeats itself from run to run:

    K = E[z v] / E[z y],   e = v - K y

(Booton, IRE Trans. Circuit Theory 1, 1954, 9; Ardalan and Paulos, IEEE Trans. Circuits and Systems
34, 1987, 593). That is exact whatever K is, if e is what it is in the run. So e has the spectrum
that it has there, unless it is white, and K is such that e has nothing in common with the other
sources of noise: z is what they make of y. Where they make little, z is y itself.
"""

from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace

import numpy as np

from proofmass.blocks.arithmetic.rounding import two_level
from proofmass.graphs.model.digraph import reached
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.decisions.compiled_decisions import Decisions, TwoRuns
from proofmass.runner.analysis.decisions.shaping import Shaping, is_white, shaping
from proofmass.runner.analysis.decisions.standing_errors import without_standing
from proofmass.runner.analysis.decisions.watched import recorded
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.linearisation import Linearisation
from proofmass.runner.analysis.linearisation.map_blocks import upstream_of
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop, of_wires
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.derivatives.dual_functions import LEVELS, reaches
from proofmass.runner.derivatives.dual_noise import NOTHING, ONE_BIT, Noisy, OneBitGain, noise_blocks
from proofmass.runner.derivatives.dual_noise import reached as reached_by
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.interpret import TickError
from proofmass.runner.run.faults import failed

FILTER = "filter of an error"  # in the place of a field of a state
_WINDOW = 256  # decisions over which signals hardly move: their means are subtracted
_LAGS = 64  # decisions, the longest lag of the autocorrelation
_VALUES = 1 << 14  # values of the output in a reference run
_ALONE = 1 << 14  # decisions from which the whole error of one run is estimated
_MEMORY = 64  # decisions, the longest lag between a source and its effect on y
_CYCLE = 1024  # decisions, the longest cycle in which a loop counts as locked
_SHOWS = 10.0  # ratio to the effect expected by chance, above which a source counts
_SAME = 0.2  # part of the error's mean square; two runs that differ by less count as the same
_TOLD = 0.05  # part of the error that repeats, from which on the note gives it


@dataclass(frozen=True)
class OneBit(OneBitGain):
    """Gain and error of a quantiser of one bit, as runs show them."""

    decisions: int  # of a run
    shaping: Shaping | None  # None for a white error
    repeating: float  # part of the mean square of the error that is the same in both runs
    correlation: float = 0.0  # the largest of e with itself, if all of e repeats
    lag: int = 0  # decisions after which the correlation is reached
    cycle: int = 0  # decisions after which a locked quantiser repeats itself, whatever the noise

    def note(self, block: str) -> str:
        """Return the note of a budget on this quantiser."""
        if self.cycle:
            return (
                f"{block}: noise moves none of {self.decisions:,} decisions in two runs, which repeat after"
                f" {self.cycle}: the loop is locked, and noise does not pass this bit"
            )
        told = f"{block}: one bit counts as a gain of {self.gain:.3g}, by two runs of {self.decisions:,} decisions; "
        if self.repeating == 1.0:
            after = "from one to the next" if self.lag == 1 else f"after {self.lag} of them"
            return (
                f"{told}its error is the same in both, whatever the noise, so that it repeats itself. It counts as"
                f" white, but is not white, with a correlation of {self.correlation:.2f} {after}: its density has"
                " tones, and holds as a mean over wide bands"
            )
        told += "its error passes for white" if self.shaping is None else "its error has the spectrum of these runs"
        if self.repeating < _TOLD:
            return told
        return f"{told}, without {100.0 * self.repeating:.0f} % of its mean square that repeat with the signals"


def noise_at(about: Linearisation, outputs: list[Endpoint]) -> Noisy:
    """Return the blocks with noise upstream of some outputs at an operating point, with the gains of one-bit ones."""
    kept, key = about.course.kept, ("noise", about.tick)
    if key not in kept:
        kept[key] = without_standing(about.plan, about.memory(), noise_blocks(about.plan))
    return with_gains(about, kept[key], outputs)


def with_gains(about: Linearisation, noise: Noisy, outputs: list[Endpoint]) -> Noisy:
    """Return the blocks with noise, with the gains of one-bit quantisers upstream of some outputs.

    Those are the ones in loops, which their own noise decides, and comparators that noise reaches.
    """
    plan = about.plan
    upstream = upstream_of(plan, (name for name, _ in outputs))
    looped = _deciding(plan, upstream, outputs)
    deciding = looped | _compared(plan, upstream & reached_by(plan, set(noise)), outputs)
    if not deciding:
        return noise
    upstream = upstream_of(plan, deciding)
    span = _VALUES * max(map(plan.stride, outputs))
    kept, key = about.course.kept, (about.tick, frozenset(deciding), span)
    if key not in kept:
        try:
            records = recorded(plan, about.memory(), upstream, deciding, span, kept)
        except TickError as error:
            raise failed(plan, error).error from error
        kept[key] = {n: tuple(_gain_of(runs, n in looped) for runs in several) for n, several in records.items()}
    return dict(sorted({**noise, **kept[key]}.items()))


def with_spectra(whole: PeriodMap, noise: Noisy) -> PeriodMap:
    """Return the map from white noise, with filters before errors of a spectrum of their own."""
    for name, several in noise.items():
        for number, one in enumerate(several):
            if isinstance(one, OneBit) and one.shaping is not None:
                own = [
                    whole.order + column
                    for column, entry in enumerate(whole.inputs)
                    if entry[:2] == (name, ONE_BIT) and entry[2] % len(several) == number
                ]
                whole = _filtered(whole, own, one.shaping, name, number) if own else whole
    return whole


def _filtered(whole: PeriodMap, columns: list[int], by: Shaping, name: str, number: int) -> PeriodMap:
    """Return the map whose columns are the outputs of a filter."""
    a, b, c, d = by.over(len(columns))
    n, more = whole.order, len(a)

    def extended(matrix: Array) -> Array:
        through = matrix[:, columns]
        matrix = matrix.copy()
        matrix[:, columns] = through @ d
        wide = np.hstack([matrix[:, :n], through @ c, matrix[:, n:]])
        return np.vstack([wide[:n], np.zeros((more, wide.shape[1])), wide[n:]])

    matrix = extended(whole.matrix)
    matrix[n : n + more, n : n + more] = a
    matrix[n : n + more, [more + column for column in columns]] = b
    return replace(
        whole,
        states=(*whole.states, *((name, f"{FILTER} {number}", i) for i in range(more))),
        matrix=matrix,
        slopes={parameter: extended(slope) for parameter, slope in whole.slopes.items()},
        point=(*whole.point, *(0.0 for _ in range(more))) if whole.point else (),
    )


def loop_through_bits(about: Linearisation, *nodes: Endpoint) -> OpenLoop | None:
    """Return the loop through an output, or the loops through several, with the gains that
    quantisers of one bit have there in a run; None without such.

    A gain depends on what is quantised: the loop is that of signals which are small beside it.
    """
    gains = with_gains(about, NOTHING, [*nodes])
    known = [(name, one) for name, several in gains.items() for one in several if isinstance(one, OneBit) and one.gain]
    if not known:
        return None
    whole = about.map(nodes, nodes, cut=True, noise=gains)
    notes = tuple(
        f"{name}: one bit counts as a gain of {one.gain:.3g}, that of {one.decisions:,} decisions in a run; another"
        " factor at the wire makes it another gain"
        for name, one in known
    )
    return of_wires(Ends(nodes, nodes).wires_of(whole), about.plan.period, notes)


def _deciding(plan: Plan, upstream: AbstractSet[str], outputs: list[Endpoint]) -> set[str]:
    """Return the blocks in loops that choose one of some levels."""
    read = {*plan.schedule.drivers.values(), *outputs}
    deciding = set[str]()
    for name in upstream:
        kind = type(plan.blocks[name])
        own = "update" in kind.functions and reaches(kind.functions["update"].function, LEVELS)
        ports = [port for port, behaviour in kind.output_functions.items() if reaches(behaviour.function, LEVELS)]
        looped = any((name, port) in read for port in ports) and name in reached(plan.readers, {name})
        if own or looped:
            deciding.add(name)
    return deciding


def _compared(plan: Plan, among: AbstractSet[str], outputs: list[Endpoint]) -> set[str]:
    """Return the blocks among some whose outputs are what a comparator decides, and are read."""
    read = {*plan.schedule.drivers.values(), *outputs}
    ports = (
        (name, port, of.function) for name in among for port, of in type(plan.blocks[name]).output_functions.items()
    )
    return {name for name, port, function in ports if (name, port) in read and reaches(function, {two_level})}


def _gain_of(runs: TwoRuns, looped: bool) -> OneBitGain:
    """Return what two runs show, found once."""
    if looped not in runs.gains:
        runs.gains[looped] = _one_bit(runs.first, runs.second, looped)
    return runs.gains[looped]


def _one_bit(first: Decisions, second: Decisions, looped: bool) -> OneBit:
    """Return the gain that comes closest to the decisions of two runs, and the error left."""
    count = min(len(first.values), len(second.values))
    cycles = [_cycle(run.levels) for run in (first, second)]
    if looped and all(cycles) and np.any(first.values[:count] != second.values[:count]):
        return OneBit(0.0, 0.0, count, None, 1.0, cycle=cycles[0])
    alone = _of_one_run(first.values[:_ALONE], first.levels[:_ALONE])
    y, v = (_apart(first.values, second.values), _apart(first.levels, second.levels))
    gain = _gain(y, v, list(map(_apart, first.sources, second.sources)))
    y *= -gain
    y += v
    e, variance = y, float(np.mean(np.square(y, out=v)))  # pages taken anew cost more than what is written there
    if looped and variance <= _SAME * alone.variance:
        return alone
    repeating = max(0.0, 1.0 - variance / alone.variance) if alone.variance else 0.0
    return OneBit(gain, variance, count, None if is_white(e) else shaping(e), repeating)


def _cycle(levels: Array) -> int:
    """Return after how many decisions all come again; 0 if that is not so, or takes many."""
    head = levels[: 4 * _CYCLE]
    for period in range(1, min(_CYCLE, len(head) // 4) + 1):
        if np.array_equal(head[period:], head[:-period]) and np.array_equal(levels[period:], levels[:-period]):
            return period
    return 0


def _apart(first: Array, second: Array) -> Array:
    count = min(len(first), len(second))
    apart = first[:count] - second[:count]
    apart /= np.sqrt(2.0)
    return apart


def _gain(y: Array, v: Array, sources: list[Array]) -> float:
    """Return K for which e has least in common with the sources; where they hardly show in y, with y itself.

    The effect of a source on y within some decisions is an instrument, as in econometrics: K = E[z
    v] / E[z y]. The part that finite means have by chance is subtracted.
    """
    products = y * y
    square = float(np.mean(products))
    product = float(np.mean(np.multiply(y, v, out=products)))
    shared, both, chance = 0.0, 0.0, 0.0
    for source in sources:
        n, power = len(source), float(np.mean(source**2))
        for lag in range(_MEMORY if power else 0):
            entry = source[: n - lag]
            by_y, by_v = (float(entry @ of[lag:n]) / (n - lag) for of in (y, v))
            shared, both, chance = shared + by_y**2 / power, both + by_y * by_v / power, chance + 1.0 / n
    if shared > _SHOWS * chance * square:
        return (both - chance * product) / (shared - chance * square)
    return product / square if square else 0.0


def _of_one_run(values: Array, levels: Array) -> OneBit:
    """Return gain and error of a run that is like every other, without what moves slowly."""
    whole = len(values) // _WINDOW * _WINDOW or len(values)
    windows = np.array([values[:whole], levels[:whole]]).reshape(2, -1, min(_WINDOW, whole))
    y, v = windows - windows.mean(axis=2, keepdims=True)
    long = y.shape[1]
    lost = long / max(long - 1, 1)
    power = float(np.mean(y**2))
    gain = float(np.mean(y * v)) / power if power else 0.0
    e = v - gain * y
    variance = float(np.mean(e**2))
    lags = range(1, min(_LAGS, long - 1) + 1)
    known = [float(np.mean(e[:, lag:] * e[:, :-lag])) / variance if variance else 0.0 for lag in lags]
    lag = int(np.argmax(np.abs(known))) if known else 0
    return OneBit(gain, variance * lost, whole, None, 1.0, known[lag] if known else 0.0, lag + 1)
