"""Transfer function of order 1 to 4 in s, in observable canonical form; continuous.

With d = b0 / a0 and coefficients divided by a0: x_i' = x_(i+1) - a_i x_1 + (b_i - d a_i) u, y =
x_1 + d u. Time is counted in 1/rate, where rate is a power of two about the fastest pole, so that
the scaling rounds nothing. Higher orders are blocks in series; the runner integrates blocks that
are wired to each other together, exactly.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class TransferFunction(Block):
    """Linear analog filter by its coefficients, of s^n first. Wire a loop through `strictly_proper_part`."""

    numerator: tuple[float, ...] = param("1", "Coefficients of the powers of s, highest first.", default=(1.0,))
    denominator: tuple[float, ...] = param("1", "Coefficients of the powers of s, highest first.", default=(1.0, 1.0))
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "Signal to filter.")


class State(NamedTuple):
    first: float
    second: float
    third: float
    fourth: float


class Constants(NamedTuple):
    rate: float  # 1/s
    direct: float
    a1: float
    a2: float
    a3: float
    a4: float
    b1: float
    b2: float
    b3: float
    b4: float
    order: int  # states beyond it stay zero; they decay, so that they add no pole at zero


@TransferFunction.requires
def requires(p: TransferFunction) -> Iterator[tuple[str, str]]:
    if not 2 <= len(p.denominator) <= 5:
        yield "denominator", "2 to 5 coefficients: order 1 to 4, higher ones as blocks in series"
    if p.denominator[0] == 0.0:
        yield "denominator", "a first coefficient other than 0"
    if len(p.numerator) > len(p.denominator):
        yield "numerator", f"at most {len(p.denominator)} coefficients, as in the denominator"


@TransferFunction.constants
def constants(p: TransferFunction, period: float) -> Constants:
    order = len(p.denominator) - 1
    a = [v / p.denominator[0] for v in p.denominator]
    b = [v / p.denominator[0] for v in (0.0,) * (order + 1 - len(p.numerator)) + p.numerator]
    powers = [-(-math.frexp(a[i])[1] // i) for i in range(1, order + 1) if a[i] != 0.0]
    power = max(powers) if powers else 0
    _, a1, a2, a3, a4 = (math.ldexp(a[i], -power * i) if i <= order else 0.0 for i in range(5))
    _, b1, b2, b3, b4 = (math.ldexp(b[i] - b[0] * a[i], -power * i) if i <= order else 0.0 for i in range(5))
    return Constants(math.ldexp(1.0, power), b[0], a1, a2, a3, a4, b1, b2, b3, b4, order)


@TransferFunction.output("{output_unit}")
def output(c: Constants, x: State, input: float) -> float:
    """The filtered signal, with the part that the input reaches at once."""
    return x.first + c.direct * input


@TransferFunction.output("{output_unit}")
def strictly_proper_part(c: Constants, x: State) -> float:
    """The filtered signal without the direct part: all of it where the numerator is shorter than the denominator."""
    return x.first


@TransferFunction.derivative(linear=True)
def derivative(c: Constants, x: State, input: float) -> State:
    return State(
        c.rate * (x.second - c.a1 * x.first + c.b1 * input),
        c.rate * (x.third - c.a2 * x.first + c.b2 * input - (x.second if c.order < 2 else 0.0)),
        c.rate * (x.fourth - c.a3 * x.first + c.b3 * input - (x.third if c.order < 3 else 0.0)),
        c.rate * (c.b4 * input - c.a4 * x.first - (x.fourth if c.order < 4 else 0.0)),
    )
