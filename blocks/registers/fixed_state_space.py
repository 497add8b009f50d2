"""Discrete state space in fixed point: x[n+1] = A x[n] + B u[n], y[n] = C x[n] + D u[n].

Each row is an exact sum of products that is rounded once, at the state or the output.
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding, fixed
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param

LARGEST_ORDER = 8


class FixedStateSpace(Block):
    """Linear filter of order 1 to 8 in fixed point; one format for coefficients, one for states."""

    transition: tuple[float, ...] = param("1", "A, row after row.", default=(0.9, 0.2, -0.2, 0.9))
    entry: tuple[float, ...] = param("1/({input_unit})", "B, one per state.", default=(0.05, 0.1))
    readout: tuple[float, ...] = param("{output_unit}", "C, one per state.", default=(1.0, 0.5))
    direct: float = param("({output_unit})/({input_unit})", "D.", default=0.0)
    input_format: Fixed = param("1", "Format of the input.", default=Fixed(16, 12))
    coefficient_format: Fixed = param("1", "Format of A, B, C and D.", default=Fixed(18, 16))
    state_format: Fixed = param("1", "Format of the states.", default=Fixed(32, 26))
    output_format: Fixed = param("1", "Format of the output.", default=Fixed(16, 12))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of states and output.", default="saturate")
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "Signal to filter.", dtype=FixedValue)

    states = Buffer("States, zero in tick 0.", FixedValue, ("entry",))


class Constants(NamedTuple):
    transition: tuple[FixedValue, ...]
    entry: tuple[FixedValue, ...]
    readout: tuple[FixedValue, ...]
    direct: FixedValue


@FixedStateSpace.requires
def requires(p: FixedStateSpace) -> Iterator[tuple[str, str]]:
    order = len(p.entry)
    if order > LARGEST_ORDER:
        yield "entry", f"at most {LARGEST_ORDER} numbers"
    if len(p.transition) != order * order:
        yield "transition", f"{order * order} numbers, as entry has {order}"
    if len(p.readout) != order:
        yield "readout", f"{order} numbers, as entry has"


@FixedStateSpace.formats
def formats(p: FixedStateSpace) -> dict[str, Fixed]:
    return {
        "input": p.input_format,
        "c": p.coefficient_format,
        "states": p.state_format,
        "output": p.output_format,
    }


@FixedStateSpace.constants
def constants(p: FixedStateSpace, period: float) -> Constants:
    def rounded(values: tuple[float, ...]) -> tuple[FixedValue, ...]:
        return tuple(fixed(value, p.coefficient_format, "half_even") for value in values)

    return Constants(rounded(p.transition), rounded(p.entry), rounded(p.readout), *rounded((p.direct,)))


@FixedStateSpace.output("{output_unit}")
def output(c: Constants, p: FixedStateSpace, states: list[FixedValue], input: FixedValue) -> FixedValue:
    """C x + D u of this tick."""
    total = c.direct * input
    for factor, state in zip(c.readout, states, strict=True):
        total = total + factor * state
    return total.to(p.output_format, p.rounding, p.overflow)


@FixedStateSpace.update
def update(c: Constants, p: FixedStateSpace, states: list[FixedValue], input: FixedValue) -> None:
    before = list(states)
    for i in range(len(before)):
        total = c.entry[i] * input
        for j in range(len(before)):
            total = total + c.transition[i * len(before) + j] * before[j]
        states[i] = total.to(p.state_format, p.rounding, p.overflow)
