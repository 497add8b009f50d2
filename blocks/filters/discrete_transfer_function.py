"""Transfer function in z, transposed direct form II (Oppenheim and Schafer, Discrete-Time Signal Processing, ch. 6).

With coefficients divided by a0: y = b0 u + s_1, then s_i = s_(i+1) + b_i u - a_i y.
"""

from collections.abc import Iterator

from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class DiscreteTransferFunction(Block):
    """Linear digital filter by its coefficients, of z^n first. Wire a loop through `strictly_proper_part`."""

    numerator: tuple[float, ...] = param("1", "Coefficients of the powers of z, highest first.", default=(1.0,))
    denominator: tuple[float, ...] = param("1", "Coefficients of the powers of z, highest first.", default=(1.0, 0.0))
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "Signal to filter.")

    forward = Buffer("b0 to bn, divided by a0.", float, ("denominator",))
    backward = Buffer("a0 to an, divided by a0.", float, ("denominator",))
    delays = Buffer("s_1 to s_n, and a zero.", float, ("denominator",))


@DiscreteTransferFunction.requires
def requires(p: DiscreteTransferFunction) -> Iterator[tuple[str, str]]:
    if not 2 <= len(p.denominator) <= 65:
        yield "denominator", "2 to 65 coefficients: order 1 to 64"
    if p.denominator[0] == 0.0:
        yield "denominator", "a first coefficient other than 0"
    if len(p.numerator) > len(p.denominator):
        yield "numerator", f"at most {len(p.denominator)} coefficients, as in the denominator"


@DiscreteTransferFunction.start
def start(p: DiscreteTransferFunction, forward: list[float], backward: list[float]) -> None:
    missing = len(p.denominator) - len(p.numerator)
    for i in range(len(p.denominator)):
        forward[i] = p.numerator[i - missing] / p.denominator[0] if i >= missing else 0.0
        backward[i] = p.denominator[i] / p.denominator[0]


@DiscreteTransferFunction.output("{output_unit}")
def output(p: DiscreteTransferFunction, forward: list[float], delays: list[float], input: float) -> float:
    """The filtered signal, with the part that the input reaches at once."""
    return forward[0] * input + delays[0]


@DiscreteTransferFunction.output("{output_unit}")
def strictly_proper_part(p: DiscreteTransferFunction, delays: list[float]) -> float:
    """The filtered signal without the direct part: all of it where the numerator is shorter than the denominator."""
    return delays[0]


@DiscreteTransferFunction.update
def update(
    p: DiscreteTransferFunction, forward: list[float], backward: list[float], delays: list[float], input: float
) -> None:
    y = forward[0] * input + delays[0]
    for i in range(1, len(delays)):
        delays[i - 1] = delays[i] + forward[i] * input - backward[i] * y
