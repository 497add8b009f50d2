"""Discrete integrator, forward Euler: y[n+1] = y[n] + gain Ts u[n], gain Ts / (z - 1).

Where it is limited, y stops at the limit and leaves it as soon as the input has the other sign
(clamping).
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import saturated
from proofmass.blocks.declaration.declare import Block, Input, param


class DiscreteIntegrator(Block):
    """Integral of a sampled signal; the output does not depend on the input of the same tick."""

    gain: float = param("({output_unit})/({input_unit})/s", "Growth of the output per second and input.", default=1.0)
    initial: float = param("{output_unit}", "Output in tick 0.", default=0.0)
    limited: bool = param("", "Whether the output is held between the limits.", default=False)
    lowest: float = param("{output_unit}", "Lower limit of the output.", default=-1.0)
    highest: float = param("{output_unit}", "Upper limit of the output.", default=1.0)
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="s")

    input = Input("{input_unit}", "Signal to integrate.")


class State(NamedTuple):
    total: float


class Constants(NamedTuple):
    step: float
    limited: bool
    lowest: float
    highest: float


@DiscreteIntegrator.requires
def requires(p: DiscreteIntegrator) -> Iterator[tuple[str, str]]:
    if p.lowest >= p.highest:
        yield "lowest", f"less than highest = {p.highest:g}"
    elif p.limited and not p.lowest <= p.initial <= p.highest:
        yield "initial", f"within the limits, {p.lowest:g} to {p.highest:g}"


@DiscreteIntegrator.constants
def constants(p: DiscreteIntegrator, period: float) -> Constants:
    return Constants(p.gain * period, p.limited, p.lowest, p.highest)


@DiscreteIntegrator.start
def start(p: DiscreteIntegrator) -> State:
    return State(p.initial)


@DiscreteIntegrator.output("{output_unit}")
def output(c: Constants, x: State) -> float:
    """The integral of the inputs before this tick."""
    return x.total


@DiscreteIntegrator.update
def update(c: Constants, x: State, input: float) -> State:
    total = x.total + c.step * input
    if c.limited:
        total = saturated(total, c.lowest, c.highest)
    return State(total)
