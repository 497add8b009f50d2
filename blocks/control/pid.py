"""PID controller D(z) = Kp + Ki Ts z/(z-1) + Kd/Ts (1-a)(z-1)/(z-a), a = exp(-2 pi f Ts).

The integral takes the error of the same sample; the derivative is filtered by a pole at `derivative_pole`
(digital quartz accelerometer, section II.B and III.A; workload W1). Where a limit clips the output, the integral
keeps its value unless the error drives it back (anti-windup by clamping).
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import exponential
from proofmass.blocks.arithmetic.rounding import saturated
from proofmass.blocks.declaration.declare import Input, param
from proofmass.blocks.parameter_sets.pid_gains import PIDGains


class PID(PIDGains):
    """Discrete PID controller with filtered derivative, output limits and anti-windup."""

    limited: bool = param("", "Whether the output is held between the limits.", default=False)
    lowest: float = param("{output_unit}", "Lower limit of the output.", default=-1.0)
    highest: float = param("{output_unit}", "Upper limit of the output.", default=1.0)

    error = Input("{input_unit}", "Setpoint minus measurement.")


class State(NamedTuple):
    integral: float
    derivative: float
    error: float


class Constants(NamedTuple):
    proportional: float
    integral: float
    derivative: float
    decay: float
    limited: bool
    lowest: float
    highest: float


@PID.requires
def requires(p: PID) -> Iterator[tuple[str, str]]:
    if p.lowest >= p.highest:
        yield "lowest", f"less than highest = {p.highest:g}"


@PID.constants
def constants(p: PID, period: float) -> Constants:
    decay = exponential(-2.0 * math.pi * p.derivative_pole * period)
    derivative = p.derivative_gain / period * (1.0 - decay)
    return Constants(p.proportional, p.integral * period, derivative, decay, p.limited, p.lowest, p.highest)


@PID.output("{output_unit}")
def output(c: Constants, x: State, error: float) -> float:
    """Controller output, within its limits."""
    integral = x.integral + c.integral * error
    derivative = c.decay * x.derivative + c.derivative * (error - x.error)
    wanted = c.proportional * error + integral + derivative
    if c.limited:
        return saturated(wanted, c.lowest, c.highest)
    return wanted


@PID.update
def update(c: Constants, x: State, error: float) -> State:
    integral = x.integral + c.integral * error
    derivative = c.decay * x.derivative + c.derivative * (error - x.error)
    if c.limited:
        wanted = c.proportional * error + integral + derivative
        if (wanted > c.highest and integral > x.integral) or (wanted < c.lowest and integral < x.integral):
            integral = x.integral
    return State(integral, derivative, error)
