"""Decimating low-pass: h[k] = g sinc(2 fc T (k - m)) w[k], m = (length - 1) / 2, once in `ratio` ticks; sum h = 1.

w is Kaiser's window, I0(beta sqrt(1 - (k/m - 1)^2)) / I0(beta): beta = 0.1102 (A - 8.7) puts the
stop-band A dB down, A over 50, behind a transition of (A - 7.95) / (14.36 (length - 1) T) Hz
(Oppenheim and Schafer, Discrete-Time Signal Processing, section 7.5).
"""

import math

from proofmass.blocks.arithmetic.decimation import accumulate
from proofmass.blocks.arithmetic.elementary import sine
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class DecimatingFilter(Block):
    """Filter of linear phase before a slower rate: flat where a CascadedIntegratorComb droops; its delay is m ticks."""

    ratio: int = param("1", "Ticks per output.", default=4, at_least=1, at_most=1024)
    length: int = param("1", "Taps.", default=63, at_least=2, at_most=65536)
    corner: float = param(
        "1", "Corner at half the gain, fc T, relative to the rate.", default=0.1, above=0.0, below=0.5
    )
    beta: float = param("1", "Shape of Kaiser's window.", default=8.0, at_least=0.0, at_most=40.0)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to decimate.")

    taps = Buffer("h, and zeros up to a multiple of the ratio.", float, (lambda p: -(-p.length // p.ratio) * p.ratio,))
    sums = Buffer("Sums of the outputs to come, the nearest first.", float, (lambda p: -(-p.length // p.ratio),))


def bessel(x: float) -> float:
    """Modified Bessel function I0 by its series."""
    total = term = 1.0
    k = 1
    while term > 1e-17 * total:
        term *= (0.5 * x / k) * (0.5 * x / k)
        total += term
        k += 1
    return total


@DecimatingFilter.start
def start(p: DecimatingFilter, taps: list[float]) -> None:
    middle = 0.5 * (p.length - 1)
    for k in range(p.length):
        x, part = math.pi * 2.0 * p.corner * (k - middle), (k - middle) / middle
        ideal = sine(x) / x if x != 0.0 else 1.0
        taps[k] = ideal * bessel(p.beta * math.sqrt(max(1.0 - part * part, 0.0)))
    total = sum(taps)
    for k in range(p.length):
        taps[k] /= total


@DecimatingFilter.output("{unit}", every="ratio")
def output(p: DecimatingFilter, sums: list[float], taps: list[float]) -> float:
    """The filtered signal, from the inputs before this tick; its gain is 1 at rest."""
    return sums[0]


@DecimatingFilter.update
def update(p: DecimatingFilter, sums: list[float], taps: list[float], tick: int, input: float) -> None:
    accumulate(sums, taps, p.ratio, tick, input)
