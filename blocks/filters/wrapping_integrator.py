"""Wrapping integrator: y[n+1] = y[n] + gain T u[n], less as many spans as put it between lowest and highest.

span = highest - lowest; lowest itself is inside, highest is not. `wraps` counts the spans that were
taken off.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param

MOST = 2.0**53  # spans of a tick, and of all, of which a number can be told from the next


class WrappingIntegrator(Block):
    """Integral that starts again at the other end: a phase from a frequency, a serrodyne ramp, an angle from a rate."""

    gain: float = param("({output_unit})/({input_unit})/s", "Growth of the output per second and input.", default=1.0)
    initial: float = param("{output_unit}", "Output in tick 0.", default=0.0)
    lowest: float = param("{output_unit}", "Lower end of the range.", default=-math.pi)
    highest: float = param("{output_unit}", "Upper end of the range.", default=math.pi)
    input_unit: str = param("", "Unit of the input.", default="rad/s")
    output_unit: str = param("", "Unit of the output.", default="rad")

    input = Input("{input_unit}", "Signal to integrate.")


class State(NamedTuple):
    total: float
    wraps: int


class Constants(NamedTuple):
    step: float
    lowest: float
    span: float


@WrappingIntegrator.requires
def requires(p: WrappingIntegrator) -> Iterator[tuple[str, str]]:
    if not p.lowest <= p.initial < p.highest:
        yield "initial", f"from {p.lowest:g} to less than {p.highest:g}"


@WrappingIntegrator.constants
def constants(p: WrappingIntegrator, period: float) -> Constants:
    return Constants(p.gain * period, p.lowest, p.highest - p.lowest)


@WrappingIntegrator.start
def start(p: WrappingIntegrator) -> State:
    return State(p.initial, 0)


@WrappingIntegrator.output(
    "{output_unit}", no_value="it has wrapped more often than a number can count: limit the input, or widen the range"
)
def output(c: Constants, x: State) -> float:
    """The integral within its range."""
    return x.total


@WrappingIntegrator.output("1")
def wraps(c: Constants, x: State) -> int:
    """Number of wraps, upward less downward."""
    return x.wraps


@WrappingIntegrator.update
def update(c: Constants, x: State, input: float) -> State:
    total = x.total + c.step * input
    turns = (total - c.lowest) / c.span
    if not -MOST < turns + x.wraps < MOST or not -MOST < turns < MOST:
        return State(math.nan, 0)
    spans = math.floor(turns)
    return State(total - c.span * float(spans), x.wraps + spans)
