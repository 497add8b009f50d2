"""Runs of a modulator for many amplitudes at once, and their signal to noise ratios."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from proofmass.runner.design.modulators.structures import Coefficients, Structure
from proofmass.runner.host.arrays import Array, Truths

SAMPLES = 16_384  # of a run, or more where the band is narrow
MOST_SAMPLES = 1 << 20
_LINES = 16  # of the band, which a run has
_SETTLE = 512  # samples left out
_LOST = 50.0  # a loop whose quantiser sees so many times full scale does not come back
_SPREAD = 3  # lines on either side of the tone that Hann's window spreads it over


@dataclass(frozen=True)
class Runs:
    """Results at several amplitudes: ratios in dB, None where the loop was lost, and swings of the states."""

    ratios: tuple[float | None, ...]
    swings: Array  # one row per amplitude


def levels_of(y: Array, levels: int) -> Array:
    """Return the level nearest each value: of a Comparator, or of a Quantiser, from -1 to 1."""
    if levels == 2:
        return np.where(y >= 0.0, 1.0, -1.0)
    last = levels - 1
    return 2.0 * np.clip(np.rint(0.5 * (y + 1.0) * last), 0.0, last) / last - 1.0


def output_of(structure: Structure, k: Coefficients, inputs: Array, levels: int) -> tuple[Array, Array, Array]:
    """Return levels, swings of the states, and lost loops; `inputs` has a row per sample."""
    n = structure.order
    rows, last = structure.stepped(k)
    x, swings = np.zeros((n, inputs.shape[1])), np.zeros((n, inputs.shape[1]))
    lost = np.zeros(inputs.shape[1], dtype=bool)
    out = np.empty_like(inputs)
    a, b, c, d = rows[:, :n], rows[:, n:], last[:n], last[n]
    for i, u in enumerate(inputs):
        y = c @ x + d * u
        v = out[i] = levels_of(y, levels)
        x = a @ x + b @ np.array([u, v])
        lost |= np.abs(y) > _LOST
        x[:, lost] = 0.0
        np.maximum(swings, np.abs(x), out=swings)
    return out, swings, lost


def tone_frequency(samples: int, band: tuple[float, float]) -> float:
    """Return the frequency of an odd number of periods near a fifth of the band, by the rate."""
    low, high = band
    return (2 * round(0.5 * samples * (low + 0.2 * (high - low))) + 1) / samples


def enough_samples(least: int, band: tuple[float, float]) -> int:
    """Return so many samples, or as many as give a narrow band lines for a tone and for noise."""
    return min(max(least, 1 << math.ceil(math.log2(_LINES / (band[1] - band[0])))), MOST_SAMPLES)


def noise_lines(samples: int, frequency: float, band: tuple[float, float]) -> tuple[Truths, Truths]:
    """Return which lines of a run are those of its tone, and which others lie in the band."""
    lines = np.arange(samples // 2 + 1)
    tone = np.abs(lines - frequency * samples) <= _SPREAD
    inside = (lines >= max(band[0] * samples, _SPREAD)) & (lines <= band[1] * samples)
    return tone, inside & ~tone


def simulated(
    structure: Structure,
    k: Coefficients,
    band: tuple[float, float],
    amplitudes: Sequence[float],
    levels: int,
    samples: int,
) -> Runs:
    """Return the runs of sines at these amplitudes, of a frequency in the band."""
    frequency = tone_frequency(samples, band)
    time = np.arange(-_SETTLE, samples)
    inputs = np.sin(2.0 * math.pi * frequency * time)[:, None] * np.asarray(amplitudes)
    out, swings, lost = output_of(structure, k, inputs, levels)
    ratios = (None if gone else ratio(v, frequency, band) for v, gone in zip(out[_SETTLE:].T, lost, strict=True))
    return Runs(tuple(ratios), swings.T)


def ratio(values: Array, frequency: float, band: tuple[float, float]) -> float | None:
    """Return the power of a tone over that of all else in the band, in dB, by Hann's window; None without a tone."""
    samples = len(values)
    window = 0.5 - 0.5 * np.cos(2.0 * math.pi * np.arange(samples) / samples)
    power = np.abs(np.fft.rfft(values * window)) ** 2
    tone, beside = noise_lines(samples, frequency, band)
    signal, noise = float(power[tone].sum()), float(power[beside].sum())
    return 10.0 * math.log10(signal / noise) if signal > 0.0 and noise > 0.0 else None
