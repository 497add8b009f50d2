"""One-sided spectral density by Welch's method: the mean over segments that overlap (IEEE Trans. AU
15, 1967, 70).

    S[k] = 2 mean |sum of w[n] (x[n] - mean of x) exp(-2 pi j k n / N)|^2 / (fs sum of w^2)

without the 2 at zero and at half the rate. The mean of each segment is taken off. Times the
equivalent noise bandwidth, fs sum of w^2 / (sum of w)^2, a line of S is the mean square of a tone
in its middle.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import Problem
from proofmass.blocks.declaration.units import short_unit
from proofmass.runner.analysis.spectrum.series import as_series, enough
from proofmass.runner.analysis.spectrum.windows import terms, window
from proofmass.runner.host.arrays import Array
from proofmass.runner.host.notebook import Plotted, Told

SEGMENTS = 8  # that fit into the signal without overlap, where the length of a segment is not said
FEWEST = 16  # values


@dataclass(frozen=True, eq=False, repr=False)
class Spectrum(Told, Plotted):
    """The one-sided spectral density of a signal; `density` is in unit^2/Hz.

    >>> import numpy
    >>> from proofmass import spectrum
    >>> times = numpy.arange(4096) / 4096.0
    >>> density = spectrum(numpy.sin(2.0 * numpy.pi * 100.0 * times), rate=4096.0, unit="V", segment=0)
    >>> density.frequencies.shape, density.density.shape, density.step
    ((2049,), (2049,), 1.0)
    """

    name: str  # of the signal
    unit: str  # of its values
    rate: float  # Hz
    values: int  # of the signal
    mean: float  # of the signal, in its unit
    window: str  # its name
    segment: int  # values
    segments: int  # that the density is the mean of
    frequencies: Array  # Hz
    density: Array  # at these frequencies, in unit^2/Hz

    @property
    def amplitude_density(self) -> Array:
        """Unit/sqrt(Hz)."""
        return np.sqrt(self.density)

    @property
    def power(self) -> Array:
        """Mean square of a tone in the middle of each line, in unit^2."""
        return self.density * self.noise_bandwidth

    @property
    def step(self) -> float:
        """Hz from line to line."""
        return self.rate / self.segment

    @cached_property
    def noise_bandwidth(self) -> float:
        """Equivalent noise bandwidth of a line in Hz."""
        shape = window(self.window, self.segment)
        return self.rate * float(np.sum(shape**2)) / float(np.sum(shape)) ** 2

    @property
    def coherent_gain(self) -> float:
        """Mean of the window: what it makes of a tone's amplitude, which `power` makes up for."""
        return terms(self.window)[0]

    @cached_property
    def freedom(self) -> float:
        """Degrees of freedom of a line: 2 for each segment, less what those that overlap have in common.

        The correlation of two segments is that of white noise (Welch 1967).
        """
        shape, hop = window(self.window, self.segment), hop_of(self.segment)
        power = float(np.sum(shape**2))
        common = 0.0
        for apart in range(1, min(self.segments, -(-self.segment // hop))):
            shared = float(np.sum(shape[apart * hop :] * shape[: -apart * hop])) / power
            common += (1.0 - apart / self.segments) * shared**2
        return 2.0 * self.segments / (1.0 + 2.0 * common)

    def within(self, band: tuple[float, float] | None) -> "np.ndarray[Any, np.dtype[np.bool_]]":
        """Return which lines lie in a band, both ends included; all but zero without one."""
        low, high = band or (0.0, math.inf)
        return (self.frequencies >= low) & (self.frequencies <= high) & (self.frequencies > 0.0)

    def rms(self, band: tuple[float, float] | None = None) -> float:
        """Root mean square of the part of the signal that lies in a band."""
        return math.sqrt(float(np.sum(self.density[self.within(band)])) * self.step)

    def slope(self, band: tuple[float, float]) -> float:
        """Return by how many dB the density rises a decade in a band, by least squares over logarithmic frequency."""
        lines = self.within(band) & (self.density > 0.0)
        if np.sum(lines) < 2:
            raise Problem(
                message="fewer than two lines of the spectrum lie in the band",
                key="band",
                got=f"{band[0]:g} Hz to {band[1]:g} Hz",
                expected=f"a band wider than the lines, which are {self.step:.4g} Hz apart",
            ).error
        decades = np.log10(self.frequencies[lines])
        weight = 1.0 / self.frequencies[lines]  # every decade counts alike
        apart = decades - np.average(decades, weights=weight)
        level = 10.0 * np.log10(self.density[lines])
        return float(np.sum(weight * apart * level) / np.sum(weight * apart**2))

    @property
    def density_unit(self) -> str:
        """Unit of the amplitude density."""
        return short_unit(f"({self.unit})/sqrt(Hz)")

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {
            "signal": self.name, "unit": self.unit, "rate_hz": self.rate, "values": self.values, "mean": self.mean,
            "window": self.window, "segment": self.segment, "segments": self.segments,
            "noise_bandwidth_hz": self.noise_bandwidth, "coherent_gain": self.coherent_gain,
            "degrees_of_freedom": self.freedom, "frequencies_hz": self.frequencies.tolist(),
            "density": self.density.tolist(),
        }  # fmt: skip


def spectrum(
    signal: Any, *, rate: float = 0.0, unit: str = "1", window: str = "hann", segment: int | None = None
) -> Spectrum:
    """The one-sided spectral density of a trace, a series or, with their `rate` in Hz, of plain values.

    Segments of so many values overlap by half. Without a `segment` it is the largest power of two
    of which 8 fit into the signal; with 0 it is the whole signal, which shows tones best.
    Raises `ModelError` for a signal of under 16 values, and for a segment that does not fit.

    `signal` is in its own unit, or plain values in `unit`. `window` is rectangular, hann, hamming,
    blackman-harris, nuttall, blackman-harris-7 or flat-top.

    >>> import numpy
    >>> from proofmass import spectrum
    >>> times = numpy.arange(4096) / 4096.0
    >>> density = spectrum(numpy.sin(2.0 * numpy.pi * 100.0 * times), rate=4096.0, unit="V", segment=0)
    >>> round(density.rms((90.0, 110.0)), 6), density.density_unit
    (0.707107, 'V/sqrt(Hz)')
    """
    series = as_series(signal, rate, unit)
    count = enough(series, FEWEST, "a spectrum")
    length = count if segment == 0 else segment or max(FEWEST, 1 << (count // SEGMENTS).bit_length() - 1)
    if not FEWEST <= length <= count:
        raise Problem(
            message="a segment of this length does not fit",
            key="segment",
            got=str(length),
            expected=f"{FEWEST} to the {count:,} values of {series.name or 'the signal'}, or 0 for all of them",
        ).error
    density, segments = _mean_density(series.values, length, window, series.rate)
    frequencies = np.arange(length // 2 + 1, dtype=np.float64) * np.float64(series.rate / length)
    mean = float(np.mean(series.values))
    return Spectrum(series.name, series.unit, series.rate, count, mean, window, length, segments, frequencies, density)


def hop_of(segment: int) -> int:
    """Values from the start of a segment to that of the next."""
    return segment - segment // 2


def _mean_density(values: Array, length: int, name: str, rate: float) -> tuple[Array, int]:
    shape = window(name, length)
    starts = range(0, len(values) - length + 1, hop_of(length))
    total = np.zeros(length // 2 + 1)
    for first in starts:
        piece = values[first : first + length]
        total += np.abs(np.fft.rfft(shape * (piece - np.mean(piece)))) ** 2
    total *= 2.0 / (len(starts) * rate * float(np.sum(shape**2)))
    total[0] *= 0.5
    if length % 2 == 0:
        total[-1] *= 0.5
    return total, len(starts)
