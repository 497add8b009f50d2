"""Coefficients of noise as IEEE Std 952 names them, fitted to a one-sided spectral density.

    S(f) = 2 N^2 + B^2 / (pi f) + 2 K^2 T^2 / (4 sin^2(pi f T)) + 2 Q^2 4 sin^2(pi f T) / T

N is white (angle or velocity random walk), B flicker (bias instability), K a random walk of the
signal, Q quantisation of its integral, T the period of the samples. The Allan variance is N^2 /
tau + 2 ln 2 B^2 / pi + K^2 tau / 3 + 3 Q^2 / tau^2.

A one-sided density of amplitude is sqrt(2) N: the standard's densities are two-sided.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import gammaincinv

from proofmass.runner.analysis.spectrum.series import Series
from proofmass.runner.analysis.spectrum.windows import window
from proofmass.runner.host.arrays import Array

NAMES = ("N", "B", "K", "Q")
CONFIDENCE = 0.95
_COMMON = 35.0 / 18.0  # variance of a mean of neighbouring lines of a Hann window, over that of independent lines
_FIRST = 2  # first line that counts: the window leaks the mean into those below
_PER_DECADE = 40  # groups of lines
_MANY = 16  # lines that a group needs, so that its mean scatters little
_ITERATIONS = 50
_NOTHING = 1e-30  # of the highest line
_EDGE = 1e-3  # to which the ends of intervals are found


@dataclass(frozen=True)
class Level:
    """A coefficient with its interval; where that begins at zero, `high` is an upper limit."""

    name: str
    value: float
    low: float
    high: float

    @property
    def seen(self) -> bool:
        """Return whether the coefficient differs from zero."""
        return self.low > 0.0


@dataclass(frozen=True)
class Levels:
    """All coefficients, and by how many dB the density that they make is off at worst."""

    levels: tuple[Level, ...]
    period: float
    misfit: float

    def __getitem__(self, name: str) -> Level:
        return self.levels[NAMES.index(name)]

    def variance(self, taus: Array) -> Array:
        """The Allan variance that the coefficients make."""
        return np.asarray(allan_terms(taus) @ np.array([level.value**2 for level in self.levels]))


def density_terms(frequencies: Array, period: float) -> Array:
    """One-sided densities of N = 1, B = 1, K = 1 and Q = 1, a column each."""
    f = np.asarray(frequencies, dtype=float)
    step = 4.0 * np.sin(np.pi * f * period) ** 2
    return np.column_stack([np.full_like(f, 2.0), 1.0 / (np.pi * f), 2.0 * period**2 / step, 2.0 * step / period])


def allan_terms(taus: Array) -> Array:
    """Allan variances of N = 1, B = 1, K = 1 and Q = 1, a column each."""
    tau = np.asarray(taus, dtype=float)
    flat = np.full_like(tau, 2.0 * math.log(2.0) / math.pi)
    return np.column_stack([1.0 / tau, flat, tau / 3.0, 3.0 / tau**2])


def fitted(series: Series) -> Levels:
    """The coefficients of a signal, by maximum likelihood of its periodogram (Whittle), with 95 % intervals."""
    lines, power = _periodogram(series)
    starts = _groups(lines)
    terms = np.add.reduceat(density_terms(lines, series.period), starts) / _sizes(starts, len(lines))[:, None]
    density = np.add.reduceat(power, starts) / _sizes(starts, len(lines))
    density = np.maximum(density, _NOTHING * float(np.max(density)))
    counts = _sizes(starts, len(lines))
    fit = _Fit(terms, density, counts)
    squares, least = fit.best()
    levels = tuple(fit.level(number, squares, least) for number in range(len(NAMES)))
    many = counts >= _MANY
    return Levels(levels, series.period, _misfit((terms @ squares)[many], density[many]))


def matched(frequencies: Array, density: Array, period: float) -> Levels:
    """The coefficients that come closest to a density without scatter, in the least squares of its relative errors."""
    terms = density_terms(frequencies, period)
    squares = _positive(terms / density[:, None], np.ones(len(density)))
    levels = tuple(
        Level(name, math.sqrt(s), math.sqrt(s), math.sqrt(s)) for name, s in zip(NAMES, squares, strict=True)
    )
    return Levels(levels, period, _misfit(terms @ squares, density))


def _periodogram(series: Series) -> tuple[Array, Array]:
    """Lines of a Hann window over the whole signal: a random walk leaks through a weaker one."""
    count = len(series.values)
    shape = window("hann", count)
    values = series.values - np.mean(series.values)
    power = np.abs(np.fft.rfft(shape * values)) ** 2 * (2.0 * series.period / np.sum(shape**2))
    last = (count - 1) // 2
    lines = np.arange(_FIRST, last + 1)
    return lines / (count * series.period), power[lines]


def _groups(lines: Array) -> Any:
    """First line of each group: single lines below, equal parts of a decade above."""
    place = np.floor(np.log10(lines / lines[0]) * _PER_DECADE)
    return np.flatnonzero(np.diff(place, prepend=-1.0) > 0)


def _sizes(starts: Any, count: int) -> Any:
    return np.diff([*starts, count])


@dataclass(frozen=True)
class _Fit:
    """Groups of lines, each with its mean density, its terms, and how many lines it has."""

    terms: Array
    density: Array
    counts: Array

    def best(self, fixed: int = -1, square: float = 0.0) -> tuple[Array, float]:
        """Squares of the coefficients that make the density most likely, one of them fixed, and
        minus its logarithm.

        The score of the likelihood is zero where least squares weighted by its own prediction come
        to rest.
        """
        free = [i for i in range(self.terms.shape[1]) if i != fixed]
        fixed_part = square * self.terms[:, fixed] if fixed >= 0 else np.zeros(len(self.density))
        model, squares = self.density.copy(), np.zeros(self.terms.shape[1])
        for _ in range(_ITERATIONS):
            weight, before = np.sqrt(self.counts) / model, squares
            squares = np.full(len(before), square)
            squares[free] = _positive(self.terms[:, free] * weight[:, None], (self.density - fixed_part) * weight)
            model = np.maximum(self.terms @ squares, 1e-12 * self.density)
            if np.all(np.abs(squares - before) <= 1e-6 * np.abs(before)):
                break
        return squares, float(np.sum(self.counts * (np.log(model) + self.density / model)))

    def level(self, number: int, squares: Array, least: float) -> Level:
        """A coefficient with the interval in which the likelihood of the others at their best stays high enough."""
        middle = float(squares[number])
        # Where the model does not suit the record, as of a vibration line, one search may end above another.
        enough = max(least, self.best(number, middle)[1]) + float(gammaincinv(0.5, CONFIDENCE)) * _COMMON

        def within(square: float) -> bool:
            return self.best(number, square)[1] <= enough

        size = middle or float(np.min(self.density / self.terms[:, number]))
        low = 0.0 if within(0.0) else _edge(within, middle, 0.5)
        while not middle and not within(size):
            size *= 0.25
        return Level(NAMES[number], *(math.sqrt(v) for v in (middle, low, _edge(within, size, 2.0))))


def _edge(within: Callable[[float], bool], inside: float, factor: float) -> float:
    """Return where a condition stops holding: growing steps find the end, halves its place."""
    outside = inside * factor
    while within(outside):
        inside, outside = outside, outside * factor
    while abs(outside / inside - 1.0) > _EDGE:
        middle = math.sqrt(inside * outside)
        inside, outside = (middle, outside) if within(middle) else (inside, middle)
    return inside


def _positive(columns: Array, wanted: Array) -> Array:
    """Least squares without negative coefficients; columns are scaled alike first."""
    sizes = np.sqrt(np.sum(columns**2, axis=0))
    # start-up time: scipy.optimize takes 0.15 s
    from scipy.optimize import nnls

    return np.asarray(nnls(columns / sizes, wanted)[0] / sizes)


def _misfit(model: Array, density: Array) -> float:
    known = (model > 0.0) & (density > 0.0)
    return float(np.max(np.abs(10.0 * np.log10(model[known] / density[known])), initial=0.0))
