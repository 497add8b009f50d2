"""The margins of many sampled loops of one kind at once, in floating point; those that it is not
sure of are named.

Each loop has L = N / D in powers of d = z - 1, which is small where loops cross over, from its
state space by Faddeev and LeVerrier (Householder, The Theory of Matrices in Numerical Analysis,
1964, 6.7). Its crossovers are bracketed on a grid of frequencies and bisected. A loop is left to
the certified path if it has another number of crossovers than the first of its kind, nearly touches
|L| = 1 elsewhere, or has a pole next to the unit circle.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from proofmass.runner.analysis.linearisation.balance import balanced
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.margins.figures import LARGEST_FACTOR, Figures
from proofmass.runner.host.arrays import Array, Complex, Truths

_SLOWEST, _DENSITY = 1e-7, 40  # rad in a sample, and points of a decade from there to half the rate
_AROUND = np.linspace(-1.0, 1.0, 30)  # of each crossover of the first loop, for each of some widths
_WIDEST, _BETWEEN = 0.3, 3.0  # largest width, by the frequency, and points between
_HALVINGS = 32  # a step from the state space follows
_STEP = 1e-5  # part of a frequency, by which a crossover may lie beside that of the polynomials
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
_NEAR = 1e-5  # distance of a pole from the unit circle, and part of a frequency, that the certified path decides on
MOVED = 0.0101  # this distance where the operating point moves: that moves no pole from further off (`poles.judge`)
_INFINITE = 1e3  # size of L at rest that rounding makes of an infinite one, at least
_NO_MODE = 1e-11  # part of the largest singular value that is zero but for rounding
_TOUCHING = 1e-3  # distance of |L| from 1 beside a crossover


class OpenLoops(NamedTuple):
    """State spaces of open loops with negative feedback: a loop a row."""

    a: Array
    b: Array
    c: Array
    d: Array


def in_rows(loops: OpenLoops) -> OpenLoops:
    """Return loops whose numbers lie one after the other: the order of sums follows from where they lie."""
    return OpenLoops(*map(np.ascontiguousarray, loops))


def open_loops(system: OpenLoop) -> OpenLoops:
    """Return a loop with one value of the wire in a period as a row."""
    a, b, c, d = system.matrices
    return OpenLoops(a[None], b[None, :, 0], c[None, 0], d[0])


@dataclass(frozen=True)
class Neutral:
    """A mode at 1 that no gain moves, such as the phase of an oscillation: it is not seen, or not reached."""

    scale: Array
    seen: bool

    def left_out(self, loops: OpenLoops) -> tuple[OpenLoops, Truths]:
        """Return the loops without it, and which of them have it, once.

        A reflection takes it to the first axis (Householder), of which the others know nothing, or
        which stays at zero.
        """
        a, b, c, d = _scaled(loops, self.scale)
        eye = np.eye(len(self.scale))
        less, through = (a - eye).transpose(0, 2, 1) if self.seen else a - eye, b if self.seen else c
        through = through / np.linalg.norm(through, axis=1, keepdims=True)
        _, sizes, turned = np.linalg.svd(np.concatenate([less, through[:, None]], axis=1))
        axis = turned[:, -1].copy()
        axis[:, 0] += np.copysign(1.0, axis[:, 0])
        mirror = eye - axis[:, :, None] * axis[:, None] / np.abs(axis[:, :1, None])
        a, b, c = mirror @ a @ mirror, (mirror @ b[:, :, None])[:, :, 0], (c[:, None] @ mirror)[:, 0]
        once = (sizes[:, -1] <= _NO_MODE * sizes[:, 0]) & (sizes[:, -2] > _NEAR * sizes[:, 0])
        return OpenLoops(a[:, 1:, 1:], b[:, 1:], c[:, 1:], d), once


def neutral_mode(loop: OpenLoops) -> Neutral | None:
    """Return the mode at 1 of the only loop that no gain moves; None if there is not just one."""
    scale = balanced(_closed(loop)[0])[1]
    modes = (Neutral(scale, seen) for seen in (False, True))
    return next((mode for mode in modes if mode.left_out(loop)[1].all()), None)


@dataclass(frozen=True)
class LoopKind:
    """Scales of the states, and crossovers in rad in a period, that the loops of one kind share."""

    scale: Array
    gain_crossovers: tuple[float, ...]
    phase_crossovers: tuple[float, ...]
    integrates: bool = False  # L is infinite at rest
    neutral: Neutral | None = None  # is left out


def kind_of(loop: OpenLoops, figures: Figures, period: float, neutral: Neutral | None = None) -> LoopKind:
    """Return the kind of the only loop, by its crossovers. Where L is zero there is no limit."""
    loop = neutral.left_out(loop)[0] if neutral else loop
    a, b, c, d = (part[0] for part in loop)
    scale, turn = balanced(_closed(loop)[0])[1], 2.0 * math.pi * period

    def counts(w: float) -> bool:
        size = abs(c @ np.linalg.solve(np.exp(1j * w) * np.eye(len(a)) - a, b) + d)
        return bool(w < math.pi * (1.0 - 1e-9) and 1.0 / LARGEST_FACTOR < size < LARGEST_FACTOR)

    gains, phases = ([turn * f for f in each] for each in (figures.gain_crossovers, figures.phase_crossovers))
    sizes = np.linalg.svd((_scaled(loop, scale).a - np.eye(len(a)))[0], compute_uv=False)
    integrates = bool(len(a) and sizes[-1] <= _NO_MODE * sizes[0])
    return LoopKind(scale, tuple(gains), tuple(filter(counts, phases)), integrates, neutral)


def grows(loops: OpenLoops, beyond: float = _NEAR) -> Truths:
    """Return which closed loops have a pole outside the unit circle, `beyond` a distance."""
    return np.asarray(np.max(np.abs(np.linalg.eigvals(_closed(loops))), axis=1, initial=0.0) > 1.0 + beyond)


def _closed(loops: OpenLoops) -> Array:
    a, b, c, d = loops
    return a - b[:, :, None] * c[:, None, :] / (1.0 + d)[:, None, None]


def _scaled(loops: OpenLoops, s: Array) -> OpenLoops:
    a, b, c, d = loops
    return in_rows(OpenLoops(a * s / s[:, None], b / s, c * s, d))


class Amounts(NamedTuple):
    """Figures of loops, one a row, infinite where there is no limit; and which rows are certain."""

    size: Array  # of the slowest pole of the closed loop
    gain_margin: Array  # factor
    gain_reduction: Array  # factor, 0 without limit
    phase_margin: Array  # rad
    delay_margin: Array  # periods
    sensitivity_peak: Array  # factor
    certain: Truths
    lowest: Array  # gain crossover, in rad a period: NaN where there is none
    places: Array  # all crossovers

    @property
    def stable(self) -> Truths:
        """Return which loops are stable."""
        return np.asarray(self.size < 1.0)

    def figures(self, row: int, period: float) -> Figures:
        """Return the figures of a stable loop."""
        return Figures(
            gain_margin=float(self.gain_margin[row]),
            gain_reduction=float(self.gain_reduction[row]),
            phase_margin=float(self.phase_margin[row]),
            delay_margin=float(self.delay_margin[row]) * period,
            sensitivity_peak=float(self.sensitivity_peak[row]),
        )


def amounts(loops: OpenLoops, kind: LoopKind) -> Amounts:
    """Return the figures of loops of a kind."""
    loops, known = kind.neutral.left_out(loops) if kind.neutral else (loops, True)
    chain = _Chain(scaled := _scaled(loops, kind.scale), kind)
    gains, sure_of_gains = chain.crossings(lambda value: np.abs(value) - 1.0, kind.gain_crossovers)
    phases, sure_of_phases = chain.crossings(lambda value: value.imag, kind.phase_crossovers, negative=True)
    limits = np.stack([chain.size, np.abs(chain.ends[1])])
    certain = known & sure_of_gains & sure_of_phases & chain.sure & (np.abs(limits - 1.0) > _NEAR).all(axis=0)
    sizes = np.hstack(
        [-responses(scaled, phases).real, *(np.where(end < 0.0, -end, 0.0)[:, None] for end in chain.ends)]
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        factors = np.where((sizes > 1.0 / LARGEST_FACTOR) & (sizes < LARGEST_FACTOR), 1.0 / sizes, np.nan)
    lags = np.angle(-responses(scaled, gains))
    one_more = np.where(np.abs(chain.ends[1]) >= 1.0, 1.0, np.inf)  # sample, which puts a pole beyond -1
    return Amounts(
        chain.size,
        np.min(np.where(factors > 1.0, factors, np.inf), axis=1, initial=np.inf),
        np.max(np.where(factors < 1.0, factors, 0.0), axis=1, initial=0.0),
        np.fmin.reduce(np.abs(lags), axis=1, initial=np.inf),
        np.fmin(one_more, np.fmin.reduce((lags % (2.0 * math.pi)) / gains, axis=1, initial=np.inf)),
        chain.peak(),
        certain,
        np.fmin.reduce(gains, axis=1, initial=np.nan),
        np.hstack([gains, phases]),
    )


def responses(loops: OpenLoops, w: Array) -> Complex:
    """Return L at a few frequencies from the state space: polynomials of many lose its digits."""
    a, b, c, d = loops
    known = np.exp(1j * np.where(np.isnan(w), 1.0, w))[:, :, None, None] * np.eye(a.shape[1]) - a[:, None]
    x = np.linalg.solve(known, np.broadcast_to(b[:, None, :, None], (*w.shape, a.shape[1], 1)))[..., 0]
    return np.where(np.isnan(w), np.nan, (x @ c[:, :, None])[:, :, 0] + d[:, None])


class _Chain:
    """Polynomials of the loops, and their values on a grid."""

    def __init__(self, loops: OpenLoops, kind: LoopKind) -> None:
        self._loops, self.poles = loops, np.linalg.eigvals(_closed(loops))
        self.size = np.max(np.abs(self.poles), axis=1, initial=0.0)
        self.above, self.below = _polynomials(loops)
        self.w = _grid(kind)
        self.values = self.at(self.w[None, :])
        with np.errstate(divide="ignore", invalid="ignore"):
            at_rest = self.above[:, 0] / self.below[:, 0]
        self.sure = np.abs(at_rest) > _INFINITE if kind.integrates else np.ones(len(at_rest), dtype=bool)
        self.ends = np.full_like(at_rest, np.inf) if kind.integrates else at_rest, self.values[:, -1].real

    def at(self, w: Array) -> Complex:
        """Return L at some frequencies, a row for each loop."""
        d = _distance(w)
        with np.errstate(divide="ignore", invalid="ignore"):
            return _value(self.above, d) / _value(self.below, d)

    def crossings(
        self, of: Callable[[Complex], Array], known: Sequence[float], negative: bool = False
    ) -> tuple[Array, Truths]:
        """Return where a function of L changes its sign, where L is negative if so wanted, and who
        is sure of it.

        NaN stands where a loop has fewer such places than another one.
        """
        value = of(self.values)
        before, after = slice(None, -1), slice(1, None)
        changed = (value[:, before] < 0.0) != (value[:, after] < 0.0)
        touching = np.zeros(len(value), dtype=bool)
        if negative:
            changed &= (self.values[:, before].real < 0.0) | (self.values[:, after].real < 0.0)
        else:
            # an extreme of |L| next to 1 may hide two more crossovers
            steps = np.diff(value, axis=1)
            extreme = (steps[:, :-1] < 0.0) != (steps[:, 1:] < 0.0)
            touching = (extreme & (np.abs(value[:, 1:-1]) < _TOUCHING)).any(axis=1)
        most = int(np.max(changed.sum(axis=1), initial=0))
        place = np.argsort(~changed, axis=1, kind="stable")[:, :most]
        counts = np.take_along_axis(changed, place, axis=1)
        low, high = self.w[place], self.w[place + 1]
        rising = np.take_along_axis(value, place, axis=1) < 0.0
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            below = (of(self.at(middle)) < 0.0) == rising
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        found = self._corrected(0.5 * (low + high), of)
        counts &= np.isfinite(found)
        if negative:
            size = -self.at(found).real
            counts &= (size > 1.0 / LARGEST_FACTOR) & (size < LARGEST_FACTOR)  # others do not limit
        return np.where(counts, found, np.nan), (counts.sum(axis=1) == len(known)) & ~touching

    def _corrected(self, w: Array, of: Callable[[Complex], Array]) -> Array:
        """Return zeros of a function of L, from those of its polynomials: a step by their slope."""
        step = _STEP * w
        slope = of(self.at(w + step)) - of(self.at(w - step))
        with np.errstate(divide="ignore", invalid="ignore"):
            by = 2.0 * step * of(responses(self._loops, w)) / slope
        return np.where(np.abs(by) < step, w - by, np.nan)

    def peak(self) -> Array:
        """Return the largest |1 / (1 + L)|: on the grid, or at the angle of a pole of the closed loop, and nearby."""
        angles = np.clip(np.abs(np.angle(self.poles)), self.w[0], math.pi)
        w = np.hstack([np.broadcast_to(self.w, self.values.shape), angles])
        best = np.argmax(self._sensitivity(w), axis=1)[:, None]
        middle = np.take_along_axis(w, best, axis=1)
        place = np.clip(np.searchsorted(self.w, middle[:, 0]), 1, len(self.w) - 2)[:, None]
        low, high = self.w[place - 1], self.w[place + 1]
        for _ in range(_HALVINGS):
            left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
            up = self._sensitivity(left) < self._sensitivity(right)
            low, high = np.where(up, left, low), np.where(up, high, right)
        at_rest = np.abs(self.below[:, :1] / (self.above[:, :1] + self.below[:, :1]))
        with np.errstate(divide="ignore", invalid="ignore"):
            found = [*(np.abs(1.0 / (1.0 + responses(self._loops, w))) for w in (0.5 * (low + high), middle)), at_rest]
        return np.asarray(np.max(np.hstack(found), axis=1))

    def _sensitivity(self, w: Array) -> Array:
        d = _distance(w)
        below = _value(self.below, d)
        return np.asarray(np.abs(below / (below + _value(self.above, d))))


def _grid(kind: LoopKind) -> Array:
    """Return frequencies, close to each other about crossovers: closer where these are."""
    count = round(_DENSITY * math.log10(math.pi / _SLOWEST))
    grid = [np.geomspace(_SLOWEST, math.pi, count)]
    for known in (np.sort(kind.gain_crossovers), np.sort(kind.phase_crossovers)):
        gaps = np.diff(known) / known[1:]
        for w, gap in zip(known, np.minimum([*gaps, 1.0], [1.0, *gaps]) if len(known) else (), strict=True):
            width, spacing = _WIDEST, max(gap, _NEAR) / _BETWEEN
            while width > 0.0:
                grid.append(w * (1.0 + width * _AROUND))
                width = 0.1 * width if 2.0 * width / len(_AROUND) > spacing else 0.0
    found = np.unique(np.concatenate(grid))
    return found[found <= math.pi]


def _distance(w: Array) -> Complex:
    """Return exp(j w) - 1 without cancellation."""
    return np.asarray(-2.0 * np.sin(0.5 * w) ** 2 + 1j * np.sin(w))


def _value(polynomials: Array, d: Complex) -> Complex:
    """Return the values of polynomials, lowest power first, at some points: a row each."""
    value = polynomials[:, -1:].astype(complex)
    for coefficient in polynomials[:, -2::-1].T:
        value = value * d + coefficient[:, None]
    return value


def _polynomials(loops: OpenLoops) -> tuple[Array, Array]:
    """Return N and D of c (z I - a)^-1 b + d, lowest power of z - 1 first."""
    a, b, c, d = loops
    count, n = b.shape
    eye = np.eye(n)
    m = a - eye
    adjoint = np.broadcast_to(eye, m.shape)
    above, below = np.zeros((count, n + 1)), np.zeros((count, n + 1))
    below[:, n] = 1.0
    for k in range(1, n + 1):
        above[:, n - k] = (c[:, None] @ (adjoint @ b[:, :, None]))[:, 0, 0]
        product = m @ adjoint
        below[:, n - k] = np.ascontiguousarray(np.diagonal(product, axis1=1, axis2=2)).sum(axis=1) / -k
        adjoint = product + below[:, n - k, None, None] * eye
    return above + d[:, None] * below, below
