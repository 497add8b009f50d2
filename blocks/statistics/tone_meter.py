"""Tone of a known frequency by least squares: input = a sin(2 pi f t) + b cos(2 pi f t) + constant (IEEE Std 1057).

t is `delay` and the time since tick 0. Over a whole number of cycles this is the discrete Fourier
transform at f (Goertzel 1958).
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import arctangent2, cosine_of_turns, sine_of_turns
from proofmass.blocks.declaration.declare import Block, Input, param

_KEPT = "the sums are those of one frequency: take a ToneMeter for each"


class ToneMeter(Block):
    """Amplitude and phase of a tone in all samples before the tick; zero before the third."""

    frequency: float = param("Hz", "Frequency of the tone.", default=10.0, above=0.0, not_driven=_KEPT)
    delay: float = param("s", "Time of tick 0, such as a clock offset.", default=0.0, at_least=0.0, not_driven=_KEPT)
    skip: int = param("1", "Ticks left out at the start, while a loop settles.", default=0, at_least=0)
    until: int = param("1", "Tick from which on nothing counts; 0 for no end.", default=0, at_least=0)
    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "Signal that holds the tone.")


class State(NamedTuple):
    samples: int
    first: float  # taken off, so that a large mean costs no digits
    sum: float
    sines: float
    cosines: float
    sine_squares: float
    products: float  # of sine and cosine
    by_sine: float
    by_cosine: float


class Constants(NamedTuple):
    turns: float  # in a tick
    delay: float  # turns before tick 0
    skip: int
    until: int


@ToneMeter.constants
def constants(p: ToneMeter, period: float) -> Constants:
    return Constants(p.frequency * period, p.frequency * p.delay, p.skip, p.until)


@ToneMeter.output("{unit}")
def amplitude(c: Constants, x: State) -> float:
    """Peak value of the tone."""
    a, b = parts(x)
    return math.sqrt(a * a + b * b)


@ToneMeter.output("rad")
def phase(c: Constants, x: State) -> float:
    """Phase of the tone as a sine, at time 0."""
    a, b = parts(x)
    return arctangent2(b, a)


def parts(x: State) -> tuple[float, float]:
    """The amplitudes of sine and cosine."""
    if x.samples < 3:
        return 0.0, 0.0
    n = float(x.samples)
    ss = x.sine_squares - x.sines * x.sines / n
    cc = (n - x.sine_squares) - x.cosines * x.cosines / n
    sc = x.products - x.sines * x.cosines / n
    us, uc = x.by_sine - x.sum * x.sines / n, x.by_cosine - x.sum * x.cosines / n
    determinant = ss * cc - sc * sc
    if determinant <= 0.0:
        return 0.0, 0.0
    return (us * cc - uc * sc) / determinant, (uc * ss - us * sc) / determinant


@ToneMeter.update
def update(c: Constants, x: State, tick: int, input: float) -> State:
    if tick < c.skip or 0 < c.until <= tick:
        return x
    first = 1.0 * input if x.samples == 0 else x.first  # measures read codes and bits too
    turns = c.turns * tick + c.delay
    u, s, k = 1.0 * input - first, sine_of_turns(turns), cosine_of_turns(turns)
    return State(
        x.samples + 1, first, x.sum + u, x.sines + s, x.cosines + k,
        x.sine_squares + s * s, x.products + s * k, x.by_sine + u * s, x.by_cosine + u * k,
    )  # fmt: skip
