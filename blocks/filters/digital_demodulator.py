"""Digital demodulator: y = 2 / ns sum over a carrier period of s[k] sin(2 pi k / ns + phase), ns samples a period.

Of a carrier A sin(2 pi k / ns + a) it gives A cos(a - phase); white noise of the samples comes
through with sqrt(2 / ns) of its standard deviation (digital quartz accelerometer, section II.B,
k_demo = 1).
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import sine
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class DigitalDemodulator(Block):
    """Amplitude of the carrier in each period, from the tick after its last sample."""

    samples: int = param("1", "Samples of a carrier period, ns.", default=8, at_least=3, at_most=4096)
    phase: float = param("rad", "Phase of the reference.", default=0.0)

    number = Input("1", "Sample of the modulated carrier.")

    reference = Buffer("The reference, with the factor 2 / ns.", float, ("samples",))


class State(NamedTuple):
    sample: int
    total: float
    amplitude: float


@DigitalDemodulator.start
def start(p: DigitalDemodulator, reference: list[float]) -> State:
    for k in range(p.samples):
        reference[k] = 2.0 / p.samples * sine(2.0 * math.pi * k / p.samples + p.phase)
    return State(0, 0.0, 0.0)


@DigitalDemodulator.output("1", every="samples")
def amplitude(p: DigitalDemodulator, x: State) -> float:
    """Amplitude of the last whole period; zero in the first."""
    return x.amplitude


@DigitalDemodulator.update
def update(p: DigitalDemodulator, x: State, reference: list[float], number: float) -> State:
    total = x.total + reference[x.sample] * number
    if x.sample + 1 == p.samples:
        return State(0, 0.0, total)
    return State(x.sample + 1, total, x.amplitude)
