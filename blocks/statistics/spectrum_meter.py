"""Spectral density at all lines by Welch's method: the mean over segments that overlap by half (Welch 1967).

    S[k] = 2 mean |sum of w[i] (u[i] - mean of u) exp(-2 pi j k i / N)|^2 T / sum of w^2
    w[i] = (1 - cos(2 pi i / N)) / 2

without the 2 at zero and at half the rate. It is `proofmass spectrum --segment N`, in the loop.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.arithmetic.fourier import fill_tables, load_ring, transform
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


def _lines(p: "SpectrumMeter") -> int:
    return p.segment // 2 + 1


class SpectrumMeter(Block):
    """Amplitude density of a signal at 0, 1 / (N T) to 1 / (2 T), over whole segments. DensityMeter takes one line."""

    segment: int = param("1", "Samples of a segment, N: a power of two.", default=256, at_least=16, at_most=1 << 20)
    skip: int = param("1", "Ticks left out at the start, while a loop settles.", default=0, at_least=0)
    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "Noise.")

    recent = Buffer("The last samples, in a ring.", float, ("segment",))
    real = Buffer("Real parts of the transform.", float, ("segment",))
    imaginary = Buffer("Imaginary parts.", float, ("segment",))
    cosines = Buffer("cos(2 pi i / N).", float, ("segment",))
    sines = Buffer("sin(2 pi i / N).", float, ("segment",))
    power = Buffer("Sums of the squares of each line.", float, (_lines,))
    amplitude = Buffer("The amplitude density of each line.", float, (_lines,))


class State(NamedTuple):
    samples: int
    segments: int


class Constants(NamedTuple):
    bits: int
    skip: int
    scale: float  # of a square, on both sides


@SpectrumMeter.requires
def requires(p: SpectrumMeter) -> Iterator[tuple[str, str]]:
    if p.segment & (p.segment - 1):
        yield "segment", "a power of two, such as 256 or 1024"


@SpectrumMeter.constants
def constants(p: SpectrumMeter, period: float) -> Constants:
    return Constants(p.segment.bit_length() - 1, p.skip, period / (0.375 * p.segment))


@SpectrumMeter.start
def start(p: SpectrumMeter, cosines: list[float], sines: list[float]) -> State:
    fill_tables(cosines, sines)
    return State(0, 0)


@SpectrumMeter.output("({unit})/sqrt(Hz)", shape=(_lines,), dtype=float)
def density(c: Constants, amplitude: list[float], out: list[float]) -> None:
    """One-sided amplitude density of each line; zero before the first segment."""
    for k in range(len(out)):
        out[k] = amplitude[k]


@SpectrumMeter.output("1")
def segments(c: Constants, x: State) -> int:
    """Number of segments so far."""
    return x.segments


@SpectrumMeter.update
def update(
    c: Constants, x: State, tick: int, recent: list[float], real: list[float], imaginary: list[float],
    cosines: list[float], sines: list[float], power: list[float], amplitude: list[float], input: float,
) -> State:  # fmt: skip
    if tick < c.skip:
        return x
    n, samples = len(recent), x.samples + 1
    recent[x.samples % n] = 1.0 * input
    if samples < n or samples % (n // 2) != 0:
        return State(samples, x.segments)
    load_ring(recent, samples % n, real, imaginary, cosines, c.bits)
    transform(real, imaginary, cosines, sines, c.bits)
    for k in range(n // 2 + 1):
        power[k] = power[k] + (real[k] * real[k] + imaginary[k] * imaginary[k])
        sides = 1.0 if k == 0 or k == n // 2 else 2.0
        amplitude[k] = math.sqrt(sides * c.scale * power[k] / float(x.segments + 1))
    return State(samples, x.segments + 1)
