"""Integrator in fixed point, forward Euler: y[n+1] = y[n] + gain Ts u[n], gain Ts / (z - 1).

The sum has a format of its own, wider than the output where small increments must not be lost; it
is rounded, and saturates or wraps, where it is kept.
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding, fixed
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedIntegrator(Block):
    """Integral of a fixed-point signal; the output does not depend on the same tick's input."""

    gain: float = param("({output_unit})/({input_unit})/s", "Growth of the output per second and input.", default=1.0)
    initial: float = param("{output_unit}", "Sum in tick 0, rounded to its format.", default=0.0)
    input_format: Fixed = param("1", "Format of the input.", default=Fixed(16, 12))
    gain_format: Fixed = param("1", "Format of gain times period.", default=Fixed(32, 30))
    sum_format: Fixed = param("1", "Format of the sum.", default=Fixed(32, 28))
    output_format: Fixed = param("1", "Format of the output.", default=Fixed(16, 12))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of sum and output.", default="saturate")
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="s")

    input = Input("{input_unit}", "Signal to integrate.", dtype=FixedValue)


class State(NamedTuple):
    total: FixedValue


class Constants(NamedTuple):
    step: FixedValue


@FixedIntegrator.formats
def formats(p: FixedIntegrator) -> dict[str, Fixed]:
    return {"input": p.input_format, "c.step": p.gain_format, "x.total": p.sum_format, "output": p.output_format}


@FixedIntegrator.constants
def constants(p: FixedIntegrator, period: float) -> Constants:
    return Constants(fixed(p.gain * period, p.gain_format, "half_even"))


@FixedIntegrator.start
def start(p: FixedIntegrator) -> State:
    return State(fixed(p.initial, p.sum_format, "half_even"))


@FixedIntegrator.output("{output_unit}")
def output(c: Constants, p: FixedIntegrator, x: State) -> FixedValue:
    """The integral of the inputs before this tick."""
    return x.total.to(p.output_format, p.rounding, p.overflow)


@FixedIntegrator.update
def update(c: Constants, p: FixedIntegrator, x: State, input: FixedValue) -> State:
    return State((x.total + c.step * input).to(p.sum_format, p.rounding, p.overflow))
