"""Second-order section: H(z) = (b0 + b1 z^-1 + b2 z^-2) / (1 + a1 z^-1 + a2 z^-2), transposed direct form II.

(Oppenheim and Schafer, Discrete-Time Signal Processing, section 6.3.)
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class SecondOrderSection(Block):
    """Biquad by its coefficients, as filter design programs print them; sections in series make any filter."""

    b0: float = param("({output_unit})/({input_unit})", "b0.", default=1.0)
    b1: float = param("({output_unit})/({input_unit})", "b1.", default=0.0)
    b2: float = param("({output_unit})/({input_unit})", "b2.", default=0.0)
    a1: float = param("1", "a1, where a0 is 1.", default=0.0)
    a2: float = param("1", "a2, where a0 is 1.", default=0.0)
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "Signal to filter.")


class State(NamedTuple):
    first: float
    second: float


@SecondOrderSection.output("{output_unit}")
def output(p: SecondOrderSection, x: State, input: float) -> float:
    """The filtered signal."""
    return p.b0 * input + x.first


@SecondOrderSection.update
def update(p: SecondOrderSection, x: State, input: float) -> State:
    y = p.b0 * input + x.first
    return State(p.b1 * input - p.a1 * y + x.second, p.b2 * input - p.a2 * y)
