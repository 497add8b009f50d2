"""Root mean square in a band: sqrt(sum y^2 / n), y the input behind Butterworth filters of fourth order.

A high-pass at the low end and a low-pass at the high one, each down by 3 dB there (Butterworth
1930); from zero on there is no high-pass, and the mean counts. The filters run from tick 0, also in
ticks that are left out. They begin as if the first value had been there for ever, so that an offset
makes no transient.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.arithmetic.prototypes import butterworth
from proofmass.blocks.arithmetic.sections import Delays, Sections, designed, settled, warped
from proofmass.blocks.arithmetic.sections import output as filtered
from proofmass.blocks.arithmetic.sections import update as moved
from proofmass.blocks.declaration.declare import Block, Input, param

_ORDER = 4


class BandMeter(Block):
    """Root mean square of a signal in a band, over all samples before the tick."""

    low: float = param("Hz", "Lower end of the band.", default=0.0, at_least=0.0)
    high: float = param("Hz", "Upper end of the band.", default=100.0, above=0.0)
    skip: int = param("1", "Ticks left out at the start, while filters and loops settle.", default=0, at_least=0)
    until: int = param("1", "Tick from which on nothing counts; 0 for no end.", default=0, at_least=0)
    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "Signal to filter.")


class State(NamedTuple):
    left: int  # ticks that are still left out
    rest: int  # samples that still count; below 0: all
    samples: int
    squares: float
    begun: bool
    s1: float
    t1: float
    s2: float
    t2: float
    s3: float
    t3: float
    s4: float
    t4: float


@BandMeter.requires
def requires(p: BandMeter) -> Iterator[tuple[str, str]]:
    if p.high <= p.low:
        yield "high", f"above low, {p.low:g} Hz"


@BandMeter.start
def start(p: BandMeter) -> State:
    rest = max(p.until - p.skip, 0) if p.until > 0 else -1
    return State(p.skip, rest, 0, 0.0, False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@BandMeter.constants
def constants(p: BandMeter, period: float) -> Sections:
    above = designed(butterworth(_ORDER), _ORDER if p.low > 0.0 else 0, True, warped(p.low, period))
    below = designed(butterworth(_ORDER), _ORDER, False, warped(p.high, period))
    return Sections(*above[:10], *below[:10])


@BandMeter.output("{unit}")
def rms(c: Sections, x: State) -> float:
    """The root mean square."""
    return math.sqrt(x.squares / float(x.samples)) if x.samples > 0 else 0.0


@BandMeter.update
def update(c: Sections, x: State, input: float) -> State:
    u = 1.0 * input
    d = Delays(x.s1, x.t1, x.s2, x.t2, x.s3, x.t3, x.s4, x.t4) if x.begun else settled(c, u)
    y, e = filtered(c, d, u), moved(c, d, u)
    counts = x.left <= 0 and x.rest != 0
    return State(
        x.left - 1 if x.left > 0 else 0,
        x.rest - 1 if counts and x.rest > 0 else x.rest,
        x.samples + 1 if counts else x.samples,
        x.squares + y * y if counts else x.squares,
        True,
        e.s1, e.t1, e.s2, e.t2, e.s3, e.t3, e.s4, e.t4,
    )  # fmt: skip
