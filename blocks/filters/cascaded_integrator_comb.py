"""Cascaded integrators and combs: H(z) = ((1 - z^-ratio) / (ratio (1 - z^-1)))^order, once in `ratio` ticks.

(Hogenauer, An economical class of digital filters for decimation and interpolation, IEEE Trans.
ASSP 29, 1981.) It is summed as the finite response that it is, `order` sums at a time, so that
nothing grows and nothing wraps: the same numbers as registers that wrap, without their poles at 1.
"""

from proofmass.blocks.arithmetic.decimation import accumulate
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class CascadedIntegratorComb(Block):
    """Decimation filter with zeros at all multiples of the slow rate; order one more than the modulator's suits it."""

    order: int = param("1", "Integrators, and combs.", default=3, at_least=1, at_most=8)
    ratio: int = param("1", "Ticks per output.", default=16, at_least=1, at_most=65536)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to decimate.")

    taps = Buffer("The impulse response, and zeros.", float, (lambda p: p.order * p.ratio,))
    sums = Buffer("Sums of the outputs to come, the nearest first.", float, ("order",))


def response(order: int, ratio: int) -> list[int]:
    """The impulse response without its scale: `ratio` ones, folded with themselves."""
    taps = [1]
    for _ in range(order):
        folded, total = [], 0
        for i in range(len(taps) + ratio - 1):
            total += (taps[i] if i < len(taps) else 0) - (taps[i - ratio] if i >= ratio else 0)
            folded.append(total)
        taps = folded
    return taps


@CascadedIntegratorComb.start
def start(p: CascadedIntegratorComb, taps: list[float]) -> None:
    for i, tap in enumerate(response(p.order, p.ratio)):
        taps[i] = tap / p.ratio**p.order


@CascadedIntegratorComb.output("{unit}", every="ratio")
def output(p: CascadedIntegratorComb, sums: list[float], taps: list[float]) -> float:
    """The filtered signal, from the inputs before this tick; its gain is 1 at rest."""
    return sums[0]


@CascadedIntegratorComb.update
def update(p: CascadedIntegratorComb, sums: list[float], taps: list[float], tick: int, input: float) -> None:
    accumulate(sums, taps, p.ratio, tick, input)
