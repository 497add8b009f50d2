"""A tone and what lies beside it: SNR, SNDR, THD, SFDR, ENOB, as IEEE Std 1241 has them, from a spectrum.

The lines about zero, the tone and its harmonics within the main lobe of the window are theirs; the
rest is noise, and goes on beneath them at the mean density of its neighbours, since it may be
shaped. Harmonics above half the rate fold back. All ratios are of mean squares;
ENOB = (SNDR - 10 log10(3/2)) / (20 log10(2)) is that of a converter which the tone fills.
"""

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import scipy.optimize

from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.analysis.spectrum.welch import Spectrum
from proofmass.runner.analysis.spectrum.windows import half_lobe, transform, window
from proofmass.runner.host.arrays import Array

_brentq: Any = scipy.optimize.brentq
HARMONICS = 9  # above the tone
_NEIGHBOURS = 8  # lobes, on each side of a tone
_BESIDE = 2  # lobes on either side of a tone, by whose lines the noise beneath it is known
_OUTSTANDING = 30.0  # a line of white noise is as high above its median once in 1e9
_ROOM = 3  # lobes that a tone, the mean and noise need
_ON_A_LINE = 1e-12  # part of a line from it
COHERENT = 1e-2  # part of a cycle by which a coherent tone may miss a whole number of cycles


@dataclass(frozen=True, eq=False)
class Tones:
    """Figures of the largest tone in a band; ratios in dB, `rms` and `noise` in the unit of the signal.

    >>> import numpy
    >>> from proofmass import spectrum, tones
    >>> times = numpy.arange(4096) / 4096.0
    >>> density = spectrum(numpy.sin(2.0 * numpy.pi * 100.0 * times), rate=4096.0, unit="V", segment=0)
    >>> tones(density).coherent, tones(density).snr > 200.0
    (True, True)
    """

    frequency: float  # Hz
    rms: float  # of the tone
    noise: float  # rms without harmonics
    snr: float  # dB, signal to noise
    sndr: float  # dB, signal to noise and distortion
    thd: float  # dB, ten harmonics to the tone
    sfdr: float  # dB, to the largest other line
    spur: float  # Hz, of the largest line beside the tone
    enob: float  # bits of a converter that the tone fills
    cycles: float  # of the tone in a segment
    leaked: float  # rms of the tone that the window lets out of its main lobe, and that counts as noise or harmonics
    mirrored: float  # part by which rms may be off, since the tone overlaps its image below zero or above half the rate
    hidden: tuple[int, ...]  # orders of harmonics that fold onto the tone or onto zero: no figure has them

    @property
    def coherent(self) -> bool:
        """Return whether a segment holds a whole number of cycles."""
        return abs(self.cycles - round(self.cycles)) <= COHERENT

    @property
    def leaks(self) -> bool:
        """Return whether noise is told more than 0.1 dB too high, or harmonics are, since the tone leaks into them."""
        return self.leaked > math.sqrt(1.0 - 10.0**-0.01) * self.noise

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return asdict(self) | {"coherent": self.coherent}


def tones(of: Spectrum, *, tone: float = 0.0, band: tuple[float, float] | None = None) -> Tones:
    """The figures of the tone near a frequency, or of the largest; what counts as noise lies in the band.

    Raises `ModelError` where a segment is too short to tell a tone from zero, and where there is
    none; TypeError for anything but a spectrum.

    `of` is a spectrum. `tone` and both ends of the `band` are in Hz.

    >>> import numpy
    >>> from proofmass import spectrum, tones
    >>> times = numpy.arange(4096) / 4096.0
    >>> density = spectrum(numpy.sin(2.0 * numpy.pi * 100.0 * times), rate=4096.0, unit="V", segment=0)
    >>> found = tones(density, tone=100.0, band=(1.0, 1000.0))
    >>> found.frequency, round(found.rms, 6)
    (100.0, 0.707107)
    """
    if not isinstance(of, Spectrum):
        raise TypeError(f"tones are those of a spectrum, not of a {type(of).__name__}: tones(spectrum(of, segment=0))")
    lobe, power = half_lobe(of.window), of.power
    middle = _middle(of, power, lobe, tone, band)
    frequency = _frequency(of, power, middle)
    inside = of.within(band) & ~_near(of, [0.0], lobe)
    main_lobe = _near(of, [frequency], lobe)
    places = {order: _folded(frequency * order, of.rate) for order in range(2, HARMONICS + 2)}
    harmonic = _near(of, places.values(), lobe) & ~main_lobe & inside
    hidden = tuple(n for n, f in places.items() if min(f, abs(f - frequency)) <= (lobe + 0.5) * of.step)
    rest = inside & ~main_lobe & ~harmonic
    if not rest.any():
        raise _no_room(of).error
    step = of.step
    floor = float(np.mean(of.density[rest]))
    noise = float(np.sum(np.where(rest, of.density, _beneath(of, rest, lobe))[of.within(band)])) * step
    beneath = min(floor, float(np.median(of.density[rest])) / math.log(2.0))  # tones lift the mean
    signal = _above(of, main_lobe, beneath)
    distortion = _above(of, harmonic, beneath)
    beside = np.where(inside & ~main_lobe, power, -1.0)
    spur = int(np.argmax(beside))
    if not signal > 0.0:
        raise _no_tone(of, tone).error
    sndr = _decibels(signal, noise + distortion)
    leaked, mirrored = _leak(of, frequency, band)
    return Tones(
        frequency=frequency,
        rms=math.sqrt(signal),
        noise=math.sqrt(noise),
        snr=_decibels(signal, noise),
        sndr=sndr,
        thd=_decibels(distortion, signal),
        sfdr=_decibels(signal, float(beside[spur])),
        spur=float(of.frequencies[spur]),
        enob=(sndr - 10.0 * math.log10(1.5)) / (20.0 * math.log10(2.0)),
        cycles=frequency / step,
        leaked=math.sqrt(signal * leaked),
        mirrored=1.0 - math.sqrt(max(1.0 - mirrored, 0.0)),
        hidden=hidden,
    )


def _leak(of: Spectrum, frequency: float, band: tuple[float, float] | None) -> tuple[float, float]:
    """Parts of the mean square in the main lobe of a tone: what lies outside and within a band, and what the
    image of the tone below zero, or above half the rate, may add to it or take from it.
    """
    turns = np.exp(2j * np.pi * frequency / of.rate * np.arange(of.segment))
    sizes = np.abs(np.fft.fft(window(of.window, of.segment) * turns))
    image = np.roll(sizes[::-1], 1)[: len(of.frequencies)]
    sizes = sizes[: len(of.frequencies)]
    once = np.where((of.frequencies == 0.0) | (2.0 * of.frequencies == of.rate), 0.5, 1.0)
    squares, common = once * (sizes**2 + image**2), once * 2.0 * sizes * image
    main_lobe = _near(of, [frequency], half_lobe(of.window))
    inside = float(np.sum(squares[main_lobe]))
    return float(np.sum(squares[of.within(band) & ~main_lobe])) / inside, float(np.sum(common[main_lobe])) / inside


def _beneath(of: Spectrum, rest: Any, lobe: int) -> Array:
    """Density of the noise at each line by the mean over its neighbours without tones: noise may be shaped."""
    lines = np.flatnonzero(rest)
    total = np.concatenate([[0.0], np.cumsum(of.density[lines])])
    reach = _BESIDE * (lobe + 1)
    first = np.maximum(np.arange(len(lines)) - reach, 0)
    last = np.minimum(np.arange(len(lines)) + reach + 1, len(lines))
    return np.asarray(np.interp(np.arange(len(of.frequencies)), lines, (total[last] - total[first]) / (last - first)))


def _above(of: Spectrum, lines: Any, floor: float) -> float:
    """Mean square of some lines without the noise in them."""
    return max(float(np.sum(of.density[lines] - floor)) * of.step, 0.0)


def _middle(of: Spectrum, power: Array, lobe: int, tone: float, band: tuple[float, float] | None) -> int:
    """Index of the highest line: near the tone that is named, or in the band."""
    lines = of.within(band) & ~_near(of, [0.0], lobe)
    if tone:
        lines = np.abs(of.frequencies - tone) <= (lobe + 1) * of.step
    if not lines.any() or len(of.frequencies) < _ROOM * (lobe + 1):
        raise _no_room(of).error
    middle = int(np.argmax(np.where(lines, power, -1.0)))
    if not power[middle] > 0.0 or not (tone or _stands_out(power, middle, lobe)):
        raise _no_tone(of, tone).error
    return middle


def _stands_out(power: Array, middle: int, lobe: int) -> bool:
    """Return whether a line is far above the median of its neighbours, beyond its own lobe: noise peaks lower."""
    reach = _NEIGHBOURS * (lobe + 1)
    below = power[max(0, middle - reach) : max(0, middle - lobe)]
    beside = np.concatenate([below, power[middle + lobe + 1 : middle + reach + 1]])
    return not len(beside) or bool(power[middle] > _OUTSTANDING * np.median(beside))


def _frequency(of: Spectrum, power: Array, middle: int) -> float:
    """Frequency of a tone between lines: where the window makes the larger neighbour of its line so high."""
    if not 0 < middle < len(power) - 1:
        return float(of.frequencies[middle])
    left, top, right = (float(power[middle + i]) for i in (-1, 0, 1))
    ratio = math.sqrt(max(left, right) / top)

    def missing(apart: float) -> float:
        return apart * (transform(of.window, 1.0 - apart) - ratio * transform(of.window, apart))

    if missing(_ON_A_LINE) >= 0.0:
        return float(of.frequencies[middle])
    apart = float(_brentq(missing, _ON_A_LINE, 0.5)) if missing(0.5) > 0.0 else 0.5  # of two lines that are alike
    return float(of.frequencies[middle]) + math.copysign(apart, right - left) * of.step


def _near(of: Spectrum, frequencies: Iterable[float], lobe: int) -> Any:
    """Lines within the main lobe of the window about some frequencies."""
    near = np.zeros(len(of.frequencies), dtype=bool)
    for frequency in frequencies:
        line = round(frequency / of.step)
        near[max(0, line - lobe) : line + lobe + 1] = True
    return near


def _folded(frequency: float, rate: float) -> float:
    """Return where a frequency appears once it is sampled."""
    rest = frequency % rate
    return min(rest, rate - rest)


def _decibels(above: float, below: float) -> float:
    if not below > 0.0:
        return math.inf
    return 10.0 * math.log10(above / below) if above > 0.0 else -math.inf


def _no_room(of: Spectrum) -> Problem:
    return Problem(
        message="too few lines to tell a tone from its surroundings",
        key="segment",
        got=f"{of.segment} values: lines {of.step:.4g} Hz apart, {2 * half_lobe(of.window) + 1} of which a tone takes",
        hint="run longer, widen the band, or take a window of fewer terms",
    )


def _no_tone(of: Spectrum, tone: float) -> Problem:
    where, cure = (f" near {tone:g} Hz", "leave the frequency out") if tone else ("", "name its frequency")
    return Problem(message=f"no tone stands out of the noise{where}", key=of.name or "signal", hint=cure)
