"""All-pass: order 1 (c + z^-1) / (1 + c z^-1), order 2 (d + e z^-1 + z^-2) / (1 + e z^-1 + d z^-2).

c = (t - 1) / (t + 1), d = (1 - t / q + t^2) / n, e = 2 (t^2 - 1) / n, n = 1 + t / q + t^2, t =
tan(pi f T): the phase passes -90 degrees an order at f (Zoelzer, DAFX, section 2.3).
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import tangent
from proofmass.blocks.declaration.declare import Block, Input, param


class AllPass(Block):
    """Turns the phase and leaves the amplitude: phase of a loop, quadrature of a carrier."""

    order: int = param("1", "1 or 2.", default=1, at_least=1, at_most=2)
    frequency: float = param("Hz", "Frequency at which the phase is -90 degrees an order.", default=100.0, above=0.0)
    quality: float = param("1", "Steepness of the phase of order 2 there.", default=0.7071067811865476, above=0.0)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to turn.")


class State(NamedTuple):
    first: float
    second: float


class Constants(NamedTuple):
    b0: float
    b1: float
    b2: float
    a1: float
    a2: float


@AllPass.constants
def constants(p: AllPass, period: float) -> Constants:
    t = tangent(math.pi * p.frequency * period)
    if p.order == 1:
        c = (t - 1.0) / (t + 1.0)
        return Constants(c, 1.0, 0.0, c, 0.0)
    n = 1.0 + t / p.quality + t * t
    d, e = (1.0 - t / p.quality + t * t) / n, 2.0 * (t * t - 1.0) / n
    return Constants(d, e, 1.0, e, d)


@AllPass.output("{unit}")
def output(c: Constants, x: State, input: float) -> float:
    """The signal with its phase turned."""
    return c.b0 * input + x.first


@AllPass.update
def update(c: Constants, x: State, input: float) -> State:
    y = c.b0 * input + x.first
    return State(c.b1 * input - c.a1 * y + x.second, c.b2 * input - c.a2 * y)
