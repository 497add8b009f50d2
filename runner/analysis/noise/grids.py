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
from collections.abc import Hashable, Mapping, MutableMapping
from dataclasses import dataclass, replace
from typing import Any, get_args

import numpy as np

from proofmass.blocks.arithmetic.mantissa import Rounding, rounded
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.lasting import Lasting
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.rings import Entry
from proofmass.runner.analysis.noise.noise_map import summed, variance
from proofmass.runner.analysis.noise.validity import ENOUGH
from proofmass.runner.derivatives.dual_noise import rounds
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.planned import Plan

_MULTIPLES = 8  # h, of which the last is 2 % of the mean square
_PERIODS = 8  # back, in which words are looked for
_NUMBERS = 4  # of a place in a period that are looked at
_MOST = 1 << 22  # entries of what is computed at a time
_TIED = 64  # parts of a step, of which ties are 5 % of the mean square
_NONE = 1e-12  # of the largest variance: no motion
_LONGEST, _SUMS = 128, 16  # words of a sum, and sums that are followed, those that come nearest
_RANGE = 64  # steps to either side of zero, over which levels are counted
_PARTS, _BITS = 1 << 24, 40  # of a step: of what is added to a grid, and of its levels
_ALIKE = 1e-6  # of the sizes of an error in a period
_OF_ONE = 12.0 / math.pi**2


@dataclass(frozen=True)
class OnGrid:
    """The error of a rounding on a grid: its levels, 0 if they are many, and what the white model is off by."""

    levels: int
    offset: float  # of the grid, in steps
    apart: float  # of the mean square of the error, or of the correlation with the next
    motion: float  # of its input in steps, rms, in all or from value to value

    def variance(self, rule: Any) -> float | None:
        """Return the variance of the error in steps by a rule of rounding, all levels as likely.

        None without a rule, or where the levels are not known.
        """
        if self.levels == 1:
            return 0.0
        if not self.levels or rule not in get_args(Rounding):
            return None
        offset = round(self.offset * _PARTS) / _PARTS
        values = (offset + np.arange(-_RANGE * self.levels, _RANGE * self.levels) / self.levels) * 2.0**_BITS
        errors = [rounded(value, _BITS, rule) - value / 2.0**_BITS for value in map(round, values.tolist())]
        return float(np.var(errors))


_EXACT = OnGrid(1, 0.0, 0.0, math.inf)


@dataclass(frozen=True)
class GridErrors:
    """Errors of roundings on grids, by block and part: their sizes, and how far they are from white and uniform."""

    sizes: Mapping[Endpoint, float]  # deviation of the error as it is over that of the white model
    apart: Mapping[Endpoint, float]  # of the mean square

    def of(self, whole: PeriodMap) -> PeriodMap:
        """Return a map with the errors of these sizes."""
        return _scaled(whole, {entry: self.sizes.get(entry[:2], 1.0) for entry in whole.inputs})


def errors_on_grids(planned: Plan, whole: PeriodMap, kept: MutableMapping[Hashable, Any]) -> GridErrors:
    """Return what grids make of the errors of a map to quantisers, which is looked at once."""
    key = "grids", whole.inputs, whole.outputs, whole.tick, whole.matrix.tobytes()
    if key not in kept:
        found = dict[Endpoint, list[tuple[float, float]]]()
        for entry, error in on_grids(whole).items():
            square = error.variance(getattr(planned.blocks[entry[0]], "rounding", ""))
            size = 1.0 if square is None else math.sqrt(12.0 * square) / whole.deviations[entry]
            unknown = error.levels and square is None
            found.setdefault(entry[:2], []).append((size, 1.0 if unknown else error.apart))
        sizes = {place: each[0][0] for place, each in found.items()}
        apart = {
            place: 1.0 if any(abs(size - sizes[place]) > _ALIKE for size, _ in each) else max(of for _, of in each)
            for place, each in found.items()
        }
        kept[key] = GridErrors({place: size for place, size in sizes.items() if size != 1.0}, apart)
    errors: GridErrors = kept[key]
    return errors


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
    own = own.to_outputs(_settling(own))
    exact, still = set[Entry](), set[Entry]()
    while True:
        more = _Words(own, exact).exact() - exact
        if not more:
            break
        exact |= more
        own = _scaled(own, dict.fromkeys(more, 0.0))
    moved = found = _Words(own, exact).errors(exact, {})
    while more := {entry for entry, error in moved.items() if error.motion < ENOUGH} - still:
        still |= more
        own = _standing(own, more)
        moved = _Words(own, exact | still).errors(exact, found)
    errors = {
        entry: replace(error, apart=max(error.apart, moved.get(entry, error).apart)) for entry, error in found.items()
    }
    return errors | dict.fromkeys(exact, _EXACT)


def _settling(own: PeriodMap) -> list[int]:
    """Return the outputs of a map whose mean square has a bound."""
    a, b, c, _ = own.parts()
    lasting = Lasting(a)
    return [i for i in range(len(own.outputs)) if not lasting.passes(b, c[i : i + 1])]


def _standing(own: PeriodMap, still: set[Entry]) -> PeriodMap:
    """Return the map in which some words z = c x + d w + s e stand still: their errors e are as z = 0 wants."""
    rows = [own.order + i for i, entry in enumerate(own.outputs) if entry in still]
    columns = [own.order + own.inputs.index(own.outputs[row - own.order]) for row in rows]
    sizes = np.diag([own.deviations.get(own.outputs[row - own.order], 1.0) for row in rows])
    matrix = own.matrix.copy()
    entering = np.linalg.solve((matrix[np.ix_(rows, columns)] + sizes).T, matrix[:, columns].T).T
    matrix[:, :-1] -= entering @ own.matrix[rows, :-1]
    matrix[:, columns] = 0.0
    return replace(own, matrix=matrix)


class _Words:
    """Values that a map rounds, and the words that it makes of them, in some periods from the last one back.

    Rows are in independent numbers of unit variance; the last entry is the value at the operating
    point.
    """

    def __init__(self, own: PeriodMap, but: set[Entry]) -> None:
        self.own = own
        a, b, c, d = own.parts()
        a, b, c = Lasting(a).without(a, b, c)
        deviations, errors = np.sqrt([variance(name) for _, name, _ in own.inputs]), len(own.inputs)
        wide = max(1, (len(a) + errors) * len(own.outputs))
        self.back = min(_PERIODS, math.isqrt(_MOST // wide), _LONGEST // max(1, len(own.outputs)))
        self.values = _forms(a, b * deviations, c, d * deviations, own.matrix[own.order :, -1], self.back)
        first = self.values.shape[2] - 1 - (self.back + 1) * errors
        columns = {entry: column for column, entry in enumerate(own.inputs)}
        words, self.columns, self.names = [], list[int](), list[Entry]()
        for period in range(self.back + 1):  # the last one is first
            for row in reversed(range(len(own.outputs))):
                if (entry := own.outputs[row]) in but:
                    continue
                column = columns[entry]
                word = self.values[period, row].copy()
                word[first + period * errors + column] += own.deviations.get(entry, 1.0) * deviations[column]
                words.append(word)
                self.columns.append(first + period * errors + column)
                self.names.append(entry)
        self.words = np.array(words).reshape(-1, self.values.shape[2])

    def exact(self) -> set[Entry]:
        """Return the roundings that are sums of words already."""
        left, _ = self._left(self.values[0])
        none = np.sum(left[:, :-1] ** 2, axis=1) <= _NONE * (np.sum(self.values[0, :, :-1] ** 2, axis=1) + 1.0)
        return {self.own.outputs[row] for row in np.flatnonzero(none)}

    def errors(self, exact: set[Entry], known: Mapping[Entry, OnGrid]) -> Mapping[Entry, OnGrid]:
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
                    error = self._error(value, change, known.get(entry), found)
                    found[entry] = replace(error, apart=max(error.apart, self._signs(entry, error.levels, change)))
        return found

    def _signs(self, entry: Entry, levels: int, change: Array) -> float:
        """Return how far successive ties made even err alike: their sign is that of sin(pi y)."""
        parts = levels or self._parts(entry)
        if not 1 < parts < _TIED:
            return 0.0
        squares = self.nearest(np.outer(np.arange(min(round(parts), _MULTIPLES)) + 0.5, change))
        alike = float(np.sum(_likeness(squares))) / parts
        return 3.0 * parts / (parts * parts + 2.0) * alike if self._parts(entry) else 0.0

    def _parts(self, entry: Entry) -> float:
        """Return the parts of a step by which ties are told, where they are made even: 12 variance = 1 + 2 / n^2."""
        more = self.own.deviations.get(entry, 1.0) ** 2 - 1.0
        return math.sqrt(2.0 / more) if more > _NONE else 0.0

    def _error(self, value: Array, change: Array, known: OnGrid | None, before: Mapping[Entry, OnGrid]) -> OnGrid:
        square = float(value[:-1] @ value[:-1])
        multiples = np.arange(1.0, known.levels or _MULTIPLES + 1 if known else _MULTIPLES + 1)
        squares = self.nearest(np.outer(multiples, value))
        none = squares.min(axis=1, initial=math.inf) <= _NONE * (multiples**2 * square + 1.0)
        levels, offset, ties = known.levels if known else 0, 0.0, 0.0
        if known is None and none.any():
            levels = int(np.argmax(none)) + 1
            left, factors = self._left(levels * value[None])
            offset = float(left[0, -1]) / levels
            ties = self._ties(factors[0], before) * (2.0 / levels) ** 2 * _OF_ONE
        own = multiples < (levels or math.inf)
        both = squares[own], self.nearest(np.outer(multiples[own], change))
        apart = [float(np.sum(_likeness(each) / multiples[own] ** 2)) * _OF_ONE for each in both]
        motion = math.sqrt(min(square, float(change[:-1] @ change[:-1])))
        return OnGrid(levels, offset, max(apart) + ties, motion)

    def nearest(self, values: Array) -> Array:
        """Return the least squares of what is left of values less sums of words, a row for each value.

        The last word alone has its own error, so its factor is known first; both whole numbers
        beside it are tried.
        """
        left, squares = values[:, None], np.zeros((len(values), 1))
        for word, column in zip(self.words, self.columns, strict=True):
            ratio = left[:, :, column] / word[column]
            if not (np.abs(ratio) > _NONE).any():
                continue
            whole = np.rint(ratio)
            both = np.concatenate([whole, np.where(ratio > whole, whole + 1.0, whole - 1.0)], axis=1)
            far = np.tile(squares, 2) + ((np.tile(ratio, 2) - both) * word[column]) ** 2
            order = np.argsort(far, axis=1, kind="stable")[:, :_SUMS]
            of, both = (order % ratio.shape[1])[:, :, None], np.take_along_axis(both, order, axis=1)
            squares = np.take_along_axis(far, order, axis=1)
            left = np.take_along_axis(left, of, axis=1) - both[:, :, None] * word
        left = np.concatenate([left, values[:, None]], axis=1)
        return np.asarray(np.sum(left[:, :, :-1] ** 2, axis=2))

    def _left(self, values: Array) -> tuple[Array, Array]:
        """Return what is left of values less the words nearest to them, one after the other, and their factors."""
        left, factors = values.copy(), np.zeros((len(values), len(self.words)))
        for place, (word, column) in enumerate(zip(self.words, self.columns, strict=True)):
            factors[:, place] = np.rint(left[:, column] / word[column])
            left -= factors[:, place, None] * word
        return left, factors

    def _ties(self, factors: Array, before: Mapping[Entry, OnGrid]) -> float:
        """Return how far the sum of words with odd factors is from even and odd alike: one of n parts is made even."""
        ties = 1.0
        for place in np.flatnonzero(np.abs(factors % 2.0 - 1.0) < _ALIKE).tolist():
            known, parts = before.get(self.names[place]), self._parts(self.names[place])
            ties *= 1.0 / (known.levels if known and known.levels else parts) if parts else 0.0
        return ties


def _likeness(squares: Array) -> Array:
    """Return the sums over k of exp(-2 pi^2 V), a column for each h."""
    return np.asarray(np.sum(np.exp(-2.0 * math.pi**2 * squares), axis=1))


def _forms(a: Array, b: Array, c: Array, d: Array, levels: Array, back: int) -> Array:
    """Return the outputs in some periods by what makes the states before all of them, and by what enters in each."""
    sizes, basis = np.linalg.eigh(summed(a, b @ b.T))
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
