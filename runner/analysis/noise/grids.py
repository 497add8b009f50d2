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
from collections.abc import Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace

import numpy as np

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.covariance import summed
from proofmass.runner.analysis.linearisation.lasting import Lasting
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.rings import Entry
from proofmass.runner.analysis.noise.noise_map import variance
from proofmass.runner.analysis.noise.validity import APART, MULTIPLES, OF_ONE, likeness, off
from proofmass.runner.derivatives.dual_noise import rounds
from proofmass.runner.derivatives.stepped_ticks import Indices
from proofmass.runner.host.arrays import Array

_PERIODS = 8  # back, in which words are looked for
COUNTED = 4  # numbers of a place in a period that are looked at
_MOST = 1 << 22  # entries of what is computed at a time
_TIED = 64  # parts of a step, of which ties are 5 % of the mean square
_NONE = 1e-12  # of the largest variance: no motion
_LONGEST, _SUMS = 128, 16  # words of a sum, and sums that are followed, those that come nearest
CONVERTED = 60  # bits that a converter drops: all parts of a step
_FADING = 0.999  # in a period, of what has no bound
NEARLY_WHOLE = 1e-6  # of the sizes of an error in a period, and of whole numbers


@dataclass(frozen=True)
class OnGrid:
    """The error of a rounding on a grid: its levels, 0 if they are many, and what the white model is off by."""

    levels: int
    offset: float  # of the grid, in steps
    apart: float  # of the mean square of the error, or of the correlation with the next
    motion: float  # of its input in steps, rms, in all or from value to value


def scaled(whole: PeriodMap, sizes: Mapping[Entry, float]) -> PeriodMap:
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
        own = scaled(own, dict.fromkeys(found, 0.0))
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
        return self.own.drops[entry].bits < CONVERTED or bool(factors.any())

    def errors(self, exact: AbstractSet[Entry], known: Mapping[Entry, OnGrid]) -> Mapping[Entry, OnGrid]:
        """Return what the errors are of all that are not exact, with the levels that are known or those it finds."""
        of_place, found = dict[Endpoint, list[int]](), dict[Entry, OnGrid]()
        for row, entry in enumerate(self.own.outputs):
            of_place.setdefault(entry[:2], []).append(row)
        for rows in of_place.values():
            for number, row in enumerate(rows[:COUNTED]):
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
        for place in np.flatnonzero(np.abs(factors % 2.0 - 1.0) < NEARLY_WHOLE).tolist():
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
