"""PID controller in fixed point: D(z) = Kp + Ki Ts z/(z-1) + Kd/Ts (1-a)(z-1)/(z-a), a = exp(-2 pi f Ts).

The equation of PID, with integral and derivative in registers of `sum_format` (digital quartz
accelerometer, section II.B and III.A). Where the output saturates, the integral keeps its value
unless the error drives it back (anti-windup by clamping): the limits are the range of the output's
format.
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import exponential
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding, fixed
from proofmass.blocks.declaration.declare import Input, param
from proofmass.blocks.parameter_sets.pid_gains import PIDGains


class FixedPID(PIDGains):
    """PID controller in fixed point, with filtered derivative, and anti-windup at its range."""

    input_format: Fixed = param("1", "Format of the error.", default=Fixed(16, 12))
    gain_format: Fixed = param("1", "Format of Kp, Ki Ts, Kd (1-a)/Ts and a.", default=Fixed(24, 20))
    sum_format: Fixed = param("1", "Format of integral and derivative.", default=Fixed(32, 26))
    output_format: Fixed = param("1", "Format of the output.", default=Fixed(16, 12))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of sums and output.", default="saturate")

    error = Input("{input_unit}", "Setpoint minus measurement.", dtype=FixedValue)


class State(NamedTuple):
    integral: FixedValue
    derivative: FixedValue
    error: FixedValue


class Constants(NamedTuple):
    proportional: FixedValue
    integral: FixedValue
    derivative: FixedValue
    decay: FixedValue


@FixedPID.formats
def formats(p: FixedPID) -> dict[str, Fixed]:
    ports = {"error": p.input_format, "output": p.output_format}
    return {**ports, "c": p.gain_format, "x": p.sum_format, "x.error": p.input_format}


@FixedPID.constants
def constants(p: FixedPID, period: float) -> Constants:
    decay = exponential(-2.0 * math.pi * p.derivative_pole * period)
    gains = (p.proportional, p.integral * period, p.derivative_gain / period * (1.0 - decay), decay)
    return Constants(*(fixed(gain, p.gain_format, "half_even") for gain in gains))


@FixedPID.output("{output_unit}")
def output(c: Constants, p: FixedPID, x: State, error: FixedValue) -> FixedValue:
    """Controller output."""
    return _wanted(c, p, x, error)[0].to(p.output_format, p.rounding, p.overflow)


@FixedPID.update
def update(c: Constants, p: FixedPID, x: State, error: FixedValue) -> State:
    wanted, integral, derivative = _wanted(c, p, x, error)
    if p.overflow == "saturate":
        ends = p.output_format.lowest, p.output_format.highest
        lowest, highest = (FixedValue(end, p.output_format.fraction) for end in ends)
        if (wanted > highest and integral > x.integral) or (wanted < lowest and integral < x.integral):
            integral = x.integral
    return State(integral, derivative, error)


def _wanted(c: Constants, p: FixedPID, x: State, error: FixedValue) -> tuple[FixedValue, FixedValue, FixedValue]:
    """The output before it is rounded, and integral and derivative that it is made of."""
    integral = (x.integral + c.integral * error).to(p.sum_format, p.rounding, p.overflow)
    slope = c.derivative * (error - x.error)
    derivative = (c.decay * x.derivative + slope).to(p.sum_format, p.rounding, p.overflow)
    return c.proportional * error + integral + derivative, integral, derivative
