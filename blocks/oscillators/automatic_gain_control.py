"""Automatic gain control: y = g u, g[n+1] = g (1 + T / tau (1 - pi |y| / (2 setpoint))), g held between two limits.

The mean of |y| is 2 / pi of a sine's amplitude A, so that g tends to setpoint / A as the logistic curve
1 / (1 + (setpoint / (A g0) - 1) exp(-t / tau)): as fast for small signals as for large ones.
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import saturated
from proofmass.blocks.declaration.declare import Block, Input, param


class AutomaticGainControl(Block):
    """Keeps the amplitude of a sine constant whatever the input's is: before a phase detector, a demodulator."""

    setpoint: float = param("{output_unit}", "Amplitude of the output.", default=1.0, above=0.0)
    time_constant: float = param("s", "Time constant of the gain, tau; many periods.", default=0.1, above=0.0)
    initial: float = param("({output_unit})/({input_unit})", "Gain in tick 0.", default=1.0, above=0.0)
    lowest: float = param("({output_unit})/({input_unit})", "Lowest gain.", default=1e-3, above=0.0)
    highest: float = param("({output_unit})/({input_unit})", "Highest gain.", default=1e3, above=0.0)
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "A sine.")


class State(NamedTuple):
    gain: float


class Constants(NamedTuple):
    part: float
    rectified: float
    lowest: float
    highest: float


@AutomaticGainControl.constants
def constants(p: AutomaticGainControl, period: float) -> Constants:
    return Constants(period / p.time_constant, 0.5 * math.pi / p.setpoint, p.lowest, p.highest)


@AutomaticGainControl.start
def start(p: AutomaticGainControl) -> State:
    return State(p.initial)


@AutomaticGainControl.output("{output_unit}")
def output(c: Constants, x: State, input: float) -> float:
    """The input with the set amplitude."""
    return x.gain * input


@AutomaticGainControl.output("({output_unit})/({input_unit})")
def gain(c: Constants, x: State) -> float:
    """The gain."""
    return x.gain


@AutomaticGainControl.update
def update(c: Constants, x: State, input: float) -> State:
    error = 1.0 - c.rectified * abs(x.gain * input)
    return State(saturated(x.gain * (1.0 + c.part * error), c.lowest, c.highest))
