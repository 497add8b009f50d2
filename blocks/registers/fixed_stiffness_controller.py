"""Stiffness controller in registers: k += gain * sum of (y_R - y) over the chips of a window, once per period.

The sum of the a priori stiffness and an accumulator of 16 bits, 12 of them after the point (Sarraf et al. 2012,
section 2.1, steps ii and iii, Fig. 2c). It corrects as a StiffnessController does.
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding, fixed
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedStiffnessController(Block):
    """Integrates the static error between a device and its reference model into the stiffness, in fixed point."""

    initial: float = param("N/m", "A priori stiffness.", default=49.5627, above=0.0)
    gain: float = param("N/m/V", "Stiffness per volt of summed error.", default=0.3592)
    input_format: Fixed = param("1", "Format of both responses.", default=Fixed(16, 12))
    gain_format: Fixed = param("1", "Format of the gain.", default=Fixed(16, 12))
    sum_format: Fixed = param("1", "Format of the summed error.", default=Fixed(20, 12))
    correction_format: Fixed = param("1", "Format of the correction.", default=Fixed(16, 12))
    output_format: Fixed = param("1", "Format of the stiffness.", default=Fixed(20, 12))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of a register.", default="saturate")

    measured = Input("V", "Response y of the device.", dtype=FixedValue)
    modelled = Input("V", "Response y_R of the reference model.", dtype=FixedValue)
    window = Input("1", "Whether the chip belongs to the window.", dtype=bool)


class State(NamedTuple):
    correction: FixedValue
    error: FixedValue


class Constants(NamedTuple):
    initial: FixedValue
    gain: FixedValue


@FixedStiffnessController.formats
def formats(p: FixedStiffnessController) -> dict[str, Fixed]:
    return {
        "measured": p.input_format,
        "modelled": p.input_format,
        "c.initial": p.output_format,
        "c.gain": p.gain_format,
        "x.correction": p.correction_format,
        "x.error": p.sum_format,
        "stiffness": p.output_format,
    }


@FixedStiffnessController.constants
def constants(p: FixedStiffnessController, period: float) -> Constants:
    return Constants(fixed(p.initial, p.output_format, "half_even"), fixed(p.gain, p.gain_format, "half_even"))


def moved(
    c: Constants, p: FixedStiffnessController, x: State, measured: FixedValue, modelled: FixedValue, window: bool
) -> State:
    if window:
        return State(x.correction, (x.error + (modelled - measured)).to(p.sum_format, p.rounding, p.overflow))
    correction = (x.correction + c.gain * x.error).to(p.correction_format, p.rounding, p.overflow)
    return State(correction, FixedValue(0, p.sum_format.fraction))


@FixedStiffnessController.output("N/m")
def stiffness(
    c: Constants, p: FixedStiffnessController, x: State, measured: FixedValue, modelled: FixedValue, window: bool
) -> FixedValue:
    """Stiffness for the reference model, corrected in the same tick."""
    correction = moved(c, p, x, measured, modelled, window).correction
    return (c.initial + correction).to(p.output_format, p.rounding, p.overflow)


@FixedStiffnessController.update
def update(
    c: Constants, p: FixedStiffnessController, x: State, measured: FixedValue, modelled: FixedValue, window: bool
) -> State:
    return moved(c, p, x, measured, modelled, window)
