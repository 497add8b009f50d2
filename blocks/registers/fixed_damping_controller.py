"""Damping controller in registers: c += gain * (h_R - h), once per period, of one coefficient of both responses.

h is that of the device, h_R of its reference model (Sarraf et al. 2012, section 2.1, steps v and
vi); why one, a DampingController says. The correction has 16 bits; counted in 2^-10 kg/s, 12 of
them are after the point.
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding, fixed, where
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedDampingController(Block):
    """Integrates the error of an impulse response into the damping, in fixed point, at the rate of periods."""

    initial: float = param("kg/s", "A priori damping.", default=3.4e-3, above=0.0)
    gain: float = param("kg/s/V", "Damping per volt of error.", default=1.453e-3)
    lowest: float = param("kg/s", "Damping that the correction never goes below.", default=3.4e-6, above=0.0)
    input_format: Fixed = param("1", "Format of both coefficients.", default=Fixed(16, 12))
    gain_format: Fixed = param("1", "Format of the gain.", default=Fixed(16, 22))
    correction_format: Fixed = param("1", "Format of the correction.", default=Fixed(16, 22))
    output_format: Fixed = param("1", "Format of the damping.", default=Fixed(17, 22))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of a register.", default="saturate")

    measured = Input("V", "Coefficient h of the device.", dtype=FixedValue)
    modelled = Input("V", "Coefficient h_R of the reference model.", dtype=FixedValue)


class State(NamedTuple):
    correction: FixedValue


class Constants(NamedTuple):
    initial: FixedValue
    gain: FixedValue
    lowest: FixedValue


@FixedDampingController.formats
def formats(p: FixedDampingController) -> dict[str, Fixed]:
    return {
        "measured": p.input_format,
        "modelled": p.input_format,
        "c": p.output_format,
        "c.gain": p.gain_format,
        "x.correction": p.correction_format,
        "damping": p.output_format,
    }


@FixedDampingController.constants
def constants(p: FixedDampingController, period: float) -> Constants:
    initial, lowest = (fixed(value, p.output_format, "half_even") for value in (p.initial, p.lowest))
    return Constants(initial, fixed(p.gain, p.gain_format, "half_even"), lowest)


def corrected(
    c: Constants, p: FixedDampingController, x: State, measured: FixedValue, modelled: FixedValue
) -> FixedValue:
    step = c.gain * (modelled - measured)
    return (x.correction + step).to(p.correction_format, p.rounding, p.overflow)


@FixedDampingController.output("kg/s")
def damping(
    c: Constants, p: FixedDampingController, x: State, measured: FixedValue, modelled: FixedValue
) -> FixedValue:
    """Damping for the reference model, corrected in the same tick."""
    total = c.initial + corrected(c, p, x, measured, modelled)
    kept: FixedValue = where(total > c.lowest, total, c.lowest)
    return kept.to(p.output_format, p.rounding, p.overflow)


@FixedDampingController.update
def update(c: Constants, p: FixedDampingController, x: State, measured: FixedValue, modelled: FixedValue) -> State:
    return State(corrected(c, p, x, measured, modelled))
