"""Loop filter of a second-order phase-locked loop: y[n] = Kp u[n] + Ki T (u[0] + ... + u[n]).

With K = 2 pi detector_gain oscillator_gain: Kp = 2 damping wn / K, Ki = wn^2 / K, wn = 2 pi
natural_frequency, so that the closed loop is (2 damping wn s + wn^2) / (s^2 + 2 damping wn s +
wn^2) where it is slow against the rate; its noise bandwidth is wn (damping + 1 / (4 damping)) / 2
Hz, one-sided (Gardner, Phaselock Techniques, 2005, chapter 2).
"""

import math
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class LoopFilter(Block):
    """Proportional and integral path from phase error to the control of an oscillator, by bandwidth and damping."""

    natural_frequency: float = param("Hz", "Natural frequency of the loop.", default=10.0, above=0.0)
    damping: float = param("1", "Damping ratio of the loop.", default=0.7071067811865476, above=0.0)
    detector_gain: float = param("({input_unit})/rad", "Output of the detector per phase.", default=1.0, above=0.0)
    oscillator_gain: float = param("Hz/({output_unit})", "Frequency per control.", default=1.0, above=0.0)
    initial: float = param("{output_unit}", "Control before tick 0.", default=0.0)
    input_unit: str = param("", "Unit of the detector's output.", default="rad")
    output_unit: str = param("", "Unit of the control.", default="Hz")

    error = Input("{input_unit}", "Output of the phase detector.")


class State(NamedTuple):
    integral: float


class Constants(NamedTuple):
    proportional: float
    integral: float


@LoopFilter.constants
def constants(p: LoopFilter, period: float) -> Constants:
    loop_gain = 2.0 * math.pi * p.detector_gain * p.oscillator_gain
    wn = 2.0 * math.pi * p.natural_frequency
    return Constants(2.0 * p.damping * wn / loop_gain, wn * wn / loop_gain * period)


@LoopFilter.start
def start(p: LoopFilter) -> State:
    return State(p.initial)


@LoopFilter.output("{output_unit}")
def control(c: Constants, x: State, error: float) -> float:
    """Control of the oscillator."""
    return c.proportional * error + (x.integral + c.integral * error)


@LoopFilter.output("{output_unit}")
def integral(c: Constants, x: State) -> float:
    """The integral alone: the settled control, without the ripple of the detector."""
    return x.integral


@LoopFilter.update
def update(c: Constants, x: State, error: float) -> State:
    return State(x.integral + c.integral * error)
