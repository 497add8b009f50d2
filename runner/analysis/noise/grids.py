"""Errors of roundings whose inputs lie on a grid: whole numbers of what was rounded before, times a few factors.

The error of rounding y is uniform over one step if no multiple h y is nearly a sum of words z,
which were rounded before, times whole numbers k. In steps, and for normal motion, its mean square
is off by no more than

    12 / pi^2 sum over h and k of exp(-2 pi^2 V[h, k]) / h^2,   V[h, k] = variance of h y - k' z

(Sripad and Snyder, IEEE Trans. Acoustics, Speech and Signal Processing 25, 1977, 442: the characteristic function at
2 pi h, which a grid repeats). The same sum for the change of y bounds the correlation of successive
errors. Where V[h] is zero, all errors are among h levels, which follow from the rule of rounding:
one level is no noise.
"""

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from statistics import fmean
from typing import TYPE_CHECKING, get_args

import numpy as np

from proofmass.blocks.arithmetic.mantissa import Drop, Rounding
from proofmass.blocks.arithmetic.rounding import round_half_even
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.decisions.one_bit import with_spectra
from proofmass.runner.analysis.linearisation.covariance import summed
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.lasting import Lasting
from proofmass.runner.analysis.linearisation.linearisation import Linearisation
from proofmass.runner.analysis.linearisation.orbit import OrbitPoint
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.rings import Entry
from proofmass.runner.analysis.noise.noise_map import variance
from proofmass.runner.analysis.noise.validity import APART, MULTIPLES, OF_ONE, likeness, off
from proofmass.runner.derivatives.dual_functions import reaches
from proofmass.runner.derivatives.dual_noise import functions_in_loop, rounding_blocks, rounds
from proofmass.runner.derivatives.stepped_ticks import Indices
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan

if TYPE_CHECKING:
    from proofmass.runner.targets.native_slopes import SlopeCode

_PERIODS = 8  # back, in which words are looked for
_NUMBERS, _SPAN = 4, 64  # of a place in a period that are looked at, and ticks at the end of a run
_STRETCH = 256  # ticks of a period at a time, where nothing lasts from one to the next
_MOST = 1 << 22  # entries of what is computed at a time
_TIED = 64  # parts of a step, of which ties are 5 % of the mean square
_NONE = 1e-12  # of the largest variance: no motion
_LONGEST, _SUMS = 128, 16  # words of a sum, and sums that are followed, those that come nearest
_RULES: tuple[Rounding, ...] = get_args(Rounding)
_BITS = 60  # that a converter drops: all parts of a step
_FADING = 0.999  # in a period, of what has no bound
_ALIKE = 1e-6  # of the sizes of an error in a period, and of whole numbers


@dataclass(frozen=True)
class OnGrid:
    """The error of a rounding on a grid: its levels, 0 if they are many, and what the white model is off by."""

    levels: int
    offset: float  # of the grid, in steps
    apart: float  # of the mean square of the error, or of the correlation with the next
    motion: float  # of its input in steps, rms, in all or from value to value


@dataclass(frozen=True)
class GridErrors:
    """Errors of roundings, by block and part: their sizes, and how far they are from white and uniform."""

    sizes: Mapping[Endpoint, float]  # deviation of the error as it is over that of one that is uniform over a step
    apart: Mapping[Endpoint, float]  # of the mean square

    def of(self, whole: PeriodMap) -> PeriodMap:
        """Return a map with the errors of these sizes."""
        return _scaled(whole, {entry: self.size(entry[:2], whole.drops.get(entry)) for entry in whole.inputs})

    def size(self, place: Endpoint, drop: Drop | None) -> float:
        """Return the size of what enters at a place: of an error that is not known, by what is dropped."""
        return self.sizes.get(place, size_of(1 << drop.bits, 0.0, drop.rounding) if drop else 1.0)

    def notes(self, blocks: Collection[str]) -> list[str]:
        """Return notes on the errors of some blocks that are neither white nor uniform."""
        largest = dict[str, float]()
        for (block, _), apart in sorted(self.apart.items()):
            if block in blocks and apart > APART:
                largest[block] = max(largest.get(block, 0.0), min(100.0 * apart, 100.0))
        return [
            f"{block}: noise moves what it rounds too little, or by too few levels, for an error that is white and"
            f" uniform: unless signals move it more, its mean square may be off by up to {percent:.3g} %"
            for block, percent in largest.items()
        ]


def errors_about(about: Linearisation, ends: Ends) -> tuple[GridErrors, tuple[PeriodMap, ...]]:
    """Return the errors upstream of some outputs at an operating point, and the maps to what quantisers are given.

    Where nothing lasts from tick to tick on the way there, they are those of short stretches of the period.
    """
    point, kept = about.point_of(ends), about.course.kept
    quantisers = _quantisers(about.plan, ends)
    key = "to quantisers", quantisers, point.map.tick, point.ticks, tuple(ends.noise.items())
    if key not in kept:
        maps = [with_spectra(whole, ends.noise) for whole in _to_quantisers(about, ends, point, quantisers)]
        kept[key] = _errors(about.plan, maps), tuple(maps)
    found: tuple[GridErrors, tuple[PeriodMap, ...]] = kept[key]
    return found


def _to_quantisers(
    about: Linearisation, ends: Ends, point: OrbitPoint, quantisers: Collection[str]
) -> Iterator[PeriodMap]:
    """Yield the maps to what quantisers are given in a period: entries of one map would be ticks squared."""
    own = Ends((), (), noise=ends.noise)
    given = {**point.where, "quantisers": quantisers}
    first = own.map(about.plan, **{**given, "span": 1}) if point.memory and point.ticks > _STRETCH else None
    if first is None or first.order:
        yield own.map(about.plan, **given, slopes=about.course.slopes)
        return
    run, end = about.course.from_memory(point.memory), first.tick + point.ticks
    for tick in range(first.tick, end, _STRETCH):
        given |= {"memory": run.to(tick), "span": min(_STRETCH, end - tick)}
        yield own.map(about.plan, **given, slopes=about.course.slopes)


def errors_along(
    plan: Plan, at: Callable[[int], Memory], ends: Ends, last: int, code: "SlopeCode | None"
) -> GridErrors:
    """Return the errors upstream of some outputs in the last ticks of a run; what stands there is not looked at.

    `at` returns the memory of the run at a tick, and `code` follows its ticks where there is such.
    """
    quantisers = _quantisers(plan, ends)
    if not quantisers:
        return GridErrors({}, {})
    longest = max(plan.stride((name, port)) for name in quantisers for port in type(plan.blocks[name]).outputs)
    span = min(last, _NUMBERS * longest, _SPAN)
    options = {"memory": at(last - span), "span": span, "slopes": lambda *_: code, "quantisers": quantisers}
    whole = Ends((), (), noise=ends.noise).map(plan, **options)
    return _errors(plan, [with_spectra(whole, ends.noise)], moving=True)


def _quantisers(plan: Plan, ends: Ends) -> tuple[str, ...]:
    """Return the blocks upstream of some outputs that round what noise moves."""
    return tuple(sorted(rounding_blocks(plan) & ends.noise.keys() & ends.blocks(plan)[0]))


def _errors(planned: Plan, maps: Iterable[PeriodMap], moving: bool = False) -> GridErrors:
    """Return the errors of maps to quantisers, or those of what moves there."""
    found = dict[Endpoint, list[tuple[float, float]]]()
    for whole in maps:
        drops = {entry: Drop(_BITS, _rule(planned.blocks[entry[0]])) for entry in whole.outputs} | {**whole.drops}
        for entry, error in on_grids(replace(whole, drops=drops)).items():
            if error.motion or not moving:
                size = size_of(error.levels or 1 << drops[entry].bits, error.offset, drops[entry].rounding)
                found.setdefault(entry[:2], []).append((size, error.apart))
    sizes = {place: math.sqrt(fmean(size**2 for size, _ in each)) for place, each in found.items()}
    apart = {
        place: 1.0 if any(abs(size - sizes[place]) > _ALIKE for size, _ in each) else max(of for _, of in each)
        for place, each in found.items()
    }
    return GridErrors(sizes, apart)


def _rule(block: Block) -> Rounding:
    """Return the rule by which a converter rounds."""
    for rule in _RULES:
        if rule == getattr(block, "rounding", None):
            return rule
    to_even = any(reaches(each.function, (round_half_even,)) for each in functions_in_loop(block).values())
    return "half_even" if to_even else "half_up"


def size_of(levels: int, offset: float, rule: Rounding) -> float:
    """Return the deviation of an error over that of one that is uniform over a step, all levels as likely.

    Ties made even add to it. Of a magnitude that is cut the sign turns with the number.
    """
    part = 1.0 / levels
    if rule == "toward_zero":
        return math.sqrt(2.0 * (1.0 - part) * (2.0 - part) if _is_whole(levels * offset) else 4.0 - part**2)
    ties = rule == "half_even" and _is_whole(levels * (0.5 - offset))
    return math.sqrt(1.0 + 2.0 * part**2 if ties else 1.0 - part**2)


def _is_whole(number: float) -> bool:
    return abs(number - round(number)) < _ALIKE


def _scaled(whole: PeriodMap, sizes: Mapping[Entry, float]) -> PeriodMap:
    """Return a map with some of its inputs in other sizes."""
    factors = [1.0] * whole.order + [sizes.get(entry, 1.0) for entry in whole.inputs] + [1.0]
    slopes = {name: slope * factors for name, slope in whole.slopes.items()}
    return replace(whole, matrix=whole.matrix * factors, slopes=slopes)


def on_grids(whole: PeriodMap) -> Mapping[Entry, OnGrid]:
    """Return what the roundings of a map to quantisers are, by their entries, where their inputs lie on a grid.

    What is rounded without an error is no word of its own: it is a sum of others. What hardly moves
    before it is rounded does not move what comes after.
    """
    own = whole.between()
    own = own.to_outputs([i for i, entry in enumerate(own.outputs) if rounds(entry[1])])
    exact, still, lasting = dict[Entry, OnGrid](), set[Entry](), _lasting(own)
    words = _Words(own, lasting, exact.keys())
    while found := {entry: error for entry, error in words.exact().items() if entry not in exact}:
        exact |= found
        own = _scaled(own, dict.fromkeys(found, 0.0))
        words = _Words(own, lasting, exact.keys())
    moved = known = words.errors(exact.keys(), {})
    while more := {entry for entry, error in moved.items() if off(error.motion) > APART} - still:
        still |= more
        own = _standing(own, more)
        moved = _Words(own, _lasting(own), exact.keys() | still).errors(exact.keys(), known)
    errors = {
        entry: replace(error, apart=max(error.apart, moved.get(entry, error).apart)) for entry, error in known.items()
    }
    return errors | exact


def _lasting(own: PeriodMap) -> Lasting:
    a, b, *_ = own.parts()
    return Lasting(a, b * np.sqrt([variance(name) for _, name, _ in own.inputs]))


def _standing(own: PeriodMap, still: set[Entry]) -> PeriodMap:
    """Return the map in which some words z = c x + d w + s e stand still: their errors e are as z = 0 wants."""
    rows = [own.order + i for i, entry in enumerate(own.outputs) if entry in still]
    columns = [own.order + own.inputs.index(own.outputs[row - own.order]) for row in rows]
    matrix = own.matrix.copy()
    entering = np.linalg.solve((matrix[np.ix_(rows, columns)] + np.eye(len(rows))).T, matrix[:, columns].T).T
    matrix[:, :-1] -= entering @ own.matrix[rows, :-1]
    matrix[:, columns] = 0.0
    return replace(own, matrix=matrix)


class _Words:
    """Values that a map rounds, and the words that it makes of them, in some periods from the last one back.

    Rows are in independent numbers of unit variance; the last entry is the value at the operating
    point.
    """

    def __init__(self, own: PeriodMap, lasting: Lasting, but: AbstractSet[Entry]) -> None:
        self.own = own
        (a, b, c, d), fading = own.parts(), 1.0
        if lasting.passes(b, c):
            fading = _FADING / max(1.0, lasting.largest)
        else:
            a, b, c = lasting.without(a, b, c)
        deviations, errors = np.sqrt([variance(name) for _, name, _ in own.inputs]), len(own.inputs)
        wide = max(1, (len(a) + errors) * len(own.outputs))
        self.back = min(_PERIODS, math.isqrt(_MOST // wide), _LONGEST // max(1, len(own.outputs)))
        states = summed(a * fading, b * deviations**2 @ b.T)
        self.values = _forms(states, a, b * deviations, c, d * deviations, own.matrix[own.order :, -1], self.back)
        first = self.values.shape[2] - 1 - (self.back + 1) * errors
        columns = {entry: column for column, entry in enumerate(own.inputs)}
        words, self.columns, self.names = [], list[int](), list[Entry]()
        for period in range(self.back + 1):  # the last one is first
            for row in reversed(range(len(own.outputs))):
                if (entry := own.outputs[row]) in but:
                    continue
                column = columns[entry]
                word = self.values[period, row].copy()
                word[first + period * errors + column] += deviations[column]
                word[-1] *= not own.rounded  # any whole number
                words.append(word)
                self.columns.append(first + period * errors + column)
                self.names.append(entry)
        self.words = np.array(words).reshape(-1, self.values.shape[2])

    def exact(self) -> dict[Entry, OnGrid]:
        """Return the roundings that are sums of words already."""
        left, factors = self._left(self.values[0])
        squares = np.sum(self.values[0, :, :-1] ** 2, axis=1)
        rows = np.flatnonzero(np.sum(left[:, :-1] ** 2, axis=1) <= _NONE * (squares + 1.0)).tolist()
        known = {self.own.outputs[row]: row for row in rows if self._has_grid(self.own.outputs[row], factors[row])}
        return {entry: OnGrid(1, 0.0, 0.0, math.sqrt(squares[row])) for entry, row in known.items()}

    def _has_grid(self, entry: Entry, factors: Array) -> bool:
        """Return whether words say where a sum of them lies: what a converter has of no word moves with signals."""
        return self.own.drops[entry].bits < _BITS or bool(factors.any())

    def errors(self, exact: AbstractSet[Entry], known: Mapping[Entry, OnGrid]) -> Mapping[Entry, OnGrid]:
        """Return what the errors are of all that are not exact, with the levels that are known or those it finds."""
        of_place, found = dict[Endpoint, list[int]](), dict[Entry, OnGrid]()
        for row, entry in enumerate(self.own.outputs):
            of_place.setdefault(entry[:2], []).append(row)
        for rows in of_place.values():
            for number, row in enumerate(rows[:_NUMBERS]):
                late = int(not number)
                if late <= self.back and self.own.outputs[row] not in exact:
                    value, entry = self.values[0, row], self.own.outputs[row]
                    change = value - self.values[late, rows[number - 1]]
                    error = self._error(entry, value, change, known.get(entry), found)
                    found[entry] = replace(error, apart=max(error.apart, self._signs(entry, error.levels, change)))
        return found

    def _signs(self, entry: Entry, levels: int, change: Array) -> float:
        """Return how far successive ties made even err alike: their sign is that of sin(pi y)."""
        parts = self._parts(entry) and (levels or self._parts(entry))
        if not 1 < parts < _TIED:
            return 0.0
        squares = self.nearest(np.outer(np.arange(min(round(parts), MULTIPLES)) + 0.5, change))
        alike = float(np.sum(likeness(squares))) / parts
        return 3.0 * parts / (parts * parts + 2.0) * alike

    def _parts(self, entry: Entry) -> float:
        """Return the parts of a step by which ties are told, where they are made even."""
        drop = self.own.drops[entry]
        return 2.0**drop.bits if drop.rounding == "half_even" else 0.0

    def _error(
        self, entry: Entry, value: Array, change: Array, known: OnGrid | None, before: Mapping[Entry, OnGrid]
    ) -> OnGrid:
        square = float(value[:-1] @ value[:-1])
        multiples = np.arange(1.0, (known.levels if known else 0) or MULTIPLES + 1)
        both = np.concatenate([np.outer(multiples, value), np.outer(multiples, change)])
        squares = np.split(self.nearest(both), 2)
        none = squares[0].min(axis=1, initial=math.inf) <= _NONE * (multiples**2 * square + 1.0)
        levels, offset, ties = known.levels if known else 0, 0.0, 0.0
        if known is None and none.any():
            several = int(np.argmax(none)) + 1
            left, factors = self._left(several * value[None])
            if self._has_grid(entry, factors[0]):
                levels, offset = several, float(left[0, -1]) / several
                ties = self._ties(factors[0], before) * (2.0 / levels) ** 2 * OF_ONE
        own = multiples < (levels or math.inf)
        apart = [float(np.sum(likeness(each[own]) / multiples[own] ** 2)) * OF_ONE for each in squares]
        motion = math.sqrt(min(square, float(change[:-1] @ change[:-1])))
        return OnGrid(levels, offset, max(apart) + ties, motion)

    def nearest(self, values: Array) -> Array:
        """Return the least squares of what is left of values less sums of words, a row for each value.

        The last word alone has its own error, so its factor is known first; both whole numbers
        beside it are tried.
        """
        own = self.words[:, self.columns]  # of words before, a word has no error
        left, squares, rows = values[:, None, self.columns], np.zeros((len(values), 1)), np.arange(len(values))[:, None]
        steps = list[tuple[int, Indices, Array]]()
        for place, word in enumerate(own):
            ratio, left = left[:, :, 0] / word[place], left[:, :, 1:]
            if not (np.abs(ratio) > _NONE).any():
                continue
            whole = np.rint(ratio)
            apart = ratio - whole
            both = np.concatenate([whole, whole + np.where(apart > 0.0, 1.0, -1.0)], axis=1)
            apart *= word[place]
            other = abs(word[place]) - np.abs(apart)
            far = np.concatenate([squares + apart**2, squares + other**2], axis=1)
            order = np.argsort(far, axis=1, kind="stable")[:, :_SUMS]
            of, both, squares = order % ratio.shape[1], both[rows, order], far[rows, order]
            left = left[rows, of] - both[:, :, None] * word[place + 1 :]
            steps.append((place, of, both))
        factors = np.zeros((*squares.shape, len(own)))
        now = np.arange(squares.shape[1])[None]
        for place, of, both in reversed(steps):
            factors[:, :, place], now = both[rows, now], of[rows, now]
        whole = np.concatenate([values[:, None] - factors @ self.words, values[:, None]], axis=1)
        return np.asarray(np.sum(whole[:, :, :-1] ** 2, axis=2))

    def _left(self, values: Array) -> tuple[Array, Array]:
        """Return what is left of values less the words nearest to them, one after the other, and their factors.

        A value ends where something is left in the column of a word: no word after it takes that away.
        """
        left, factors, rows = values.copy(), np.zeros((len(values), len(self.words))), np.arange(len(values))
        most = _NONE * (np.sum(values[:, :-1] ** 2, axis=1) + 1.0)
        for place, (word, column) in enumerate(zip(self.words, self.columns, strict=True)):
            ratio = left[rows, column] / word[column]
            whole = np.rint(ratio)
            near = ((ratio - whole) * word[column]) ** 2 <= most[rows]
            rows, whole = rows[near], whole[near]
            factors[rows, place] = whole
            moved = np.flatnonzero(whole)
            left[rows[moved]] -= whole[moved, None] * word
        return left, factors

    def _ties(self, factors: Array, before: Mapping[Entry, OnGrid]) -> float:
        """Return how far the sum of words with odd factors is from even and odd alike: one of n parts is made even."""
        ties = 1.0
        for place in np.flatnonzero(np.abs(factors % 2.0 - 1.0) < _ALIKE).tolist():
            known, parts = before.get(self.names[place]), self._parts(self.names[place])
            ties *= 1.0 / (known.levels if known and known.levels else parts) if parts else 0.0
        return ties


def _forms(states: Array, a: Array, b: Array, c: Array, d: Array, levels: Array, back: int) -> Array:
    """Return the outputs in some periods by what makes the states before all of them, and by what enters in each."""
    sizes, basis = np.linalg.eigh(states)
    states, wide = basis * np.sqrt(np.maximum(sizes, 0.0)), b.shape[1]
    moved = np.hstack([states, np.zeros((len(a), wide * (back + 1) + 1))])
    forms: list[Array] = []
    for period in range(back, -1, -1):
        new = slice(states.shape[1] + wide * period, states.shape[1] + wide * (period + 1))
        output, moved = c @ moved, a @ moved
        output[:, new] += d
        output[:, -1] = levels
        moved[:, new] += b
        forms.insert(0, output)
    return np.array(forms)
