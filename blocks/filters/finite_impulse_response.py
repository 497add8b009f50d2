"""Finite impulse response: y[n] = h0 u[n] + h1 u[n-1] + ... + hm u[n-m], transposed direct form.

(Oppenheim and Schafer, Discrete-Time Signal Processing, section 6.5.)
"""

from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class FiniteImpulseResponse(Block):
    """Filter by its taps: linear phase, matched filters, decimation before a slower block."""

    taps: tuple[float, ...] = param("({output_unit})/({input_unit})", "h0 to hm.", default=(0.25, 0.5, 0.25))
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "Signal to filter.")

    weights = Buffer("The taps.", float, ("taps",))
    sums = Buffer("Sums of the outputs to come, and a zero.", float, ("taps",))


@FiniteImpulseResponse.start
def start(p: FiniteImpulseResponse, weights: list[float]) -> None:
    for i in range(len(p.taps)):
        weights[i] = p.taps[i]


@FiniteImpulseResponse.output("{output_unit}")
def output(p: FiniteImpulseResponse, weights: list[float], sums: list[float], input: float) -> float:
    """The filtered signal."""
    return weights[0] * input + sums[0]


@FiniteImpulseResponse.update
def update(p: FiniteImpulseResponse, weights: list[float], sums: list[float], input: float) -> None:
    for i in range(1, len(weights)):
        sums[i - 1] = sums[i] + weights[i] * input
