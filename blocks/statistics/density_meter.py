"""Spectral density at one frequency by Welch's method: the mean over segments that overlap by half (Welch 1967).

    S = 2 mean |sum of w[i] (u[i] - mean of u) exp(-2 pi j f i T)|^2 T / sum of w^2,   w = (1 - cos(2 pi i / N)) / 2

without the 2 at zero and at half the rate. It is the line of `proofmass spectrum --segment N` at f.
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import cosine_of_turns, sine_of_turns
from proofmass.blocks.arithmetic.geometric_series import summed
from proofmass.blocks.declaration.declare import Block, Input, param

_KEPT = "the sums are those of one frequency: take a DensityMeter for each"


class DensityMeter(Block):
    """Amplitude density of a signal at a frequency, over all whole segments before the tick; zero before the first."""

    frequency: float = param("Hz", "Frequency of the density.", default=10.0, at_least=0.0, not_driven=_KEPT)
    segment: int = param("1", "Samples of a segment.", default=256, at_least=16, at_most=10**7)
    skip: int = param("1", "Ticks left out at the start, while a loop settles.", default=0, at_least=0)
    until: int = param("1", "Tick from which on nothing counts; 0 for no end.", default=0, at_least=0)
    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "Noise.")


class State(NamedTuple):
    segments: int
    power: float
    sum: float  # of the segment that began with the first sample, and of those that follow it without overlap
    real: float
    imaginary: float
    later_sum: float  # of the segments that lie between these
    later_real: float
    later_imaginary: float


class Constants(NamedTuple):
    turns: float  # in a tick
    segment: int
    hop: int
    skip: int
    until: int
    real: float  # the window alone at the frequency
    imaginary: float
    scale: float


@DensityMeter.constants
def constants(p: DensityMeter, period: float) -> Constants:
    turns, n = p.frequency * period, p.segment
    middle, low, high = summed(turns, n), summed(turns - 1.0 / n, n), summed(turns + 1.0 / n, n)
    real = 0.5 * middle[0] - 0.25 * low[0] - 0.25 * high[0]
    imaginary = 0.5 * middle[1] - 0.25 * low[1] - 0.25 * high[1]
    sides = 1.0 if turns == 0.0 or turns == 0.5 else 2.0
    return Constants(turns, n, n - n // 2, p.skip, p.until, real, imaginary, sides * period / (0.375 * n))


@DensityMeter.output("({unit})/sqrt(Hz)")
def density(c: Constants, x: State) -> float:
    """One-sided amplitude density."""
    return math.sqrt(c.scale * x.power / float(x.segments)) if x.segments > 0 else 0.0


@DensityMeter.update
def update(c: Constants, x: State, tick: int, input: float) -> State:
    if tick < c.skip or 0 < c.until <= tick:
        return x
    n, u = tick - c.skip, 1.0 * input  # measures read codes and bits too
    i = n % (2 * c.hop)
    k = i - c.hop if i >= c.hop else i + c.hop
    total, real, imaginary = added(c, i, u, x.sum, x.real, x.imaginary)
    later, later_real, later_imaginary = added(c, k, u, x.later_sum, x.later_real, x.later_imaginary)
    power, segments = x.power, x.segments
    if i == c.segment - 1:
        power, segments = power + squared(c, total, real, imaginary), segments + 1
    if k == c.segment - 1 and n >= c.segment:
        power, segments = power + squared(c, later, later_real, later_imaginary), segments + 1
    return State(segments, power, total, real, imaginary, later, later_real, later_imaginary)


def added(c: Constants, i: int, u: float, total: float, real: float, imaginary: float) -> tuple[float, float, float]:
    """The sums of a segment with its sample i; they begin anew with sample 0."""
    if i >= c.segment:
        return total, real, imaginary
    w = u * (0.5 - 0.5 * cosine_of_turns(i / c.segment))
    keep, turns = (0.0 if i == 0 else 1.0), c.turns * i
    return (
        keep * total + u, keep * real + w * cosine_of_turns(turns), keep * imaginary - w * sine_of_turns(turns),
    )  # fmt: skip


def squared(c: Constants, total: float, real: float, imaginary: float) -> float:
    """The periodogram of a whole segment, without its mean."""
    mean = total / float(c.segment)
    a, b = real - mean * c.real, imaginary - mean * c.imaginary
    return a * a + b * b
