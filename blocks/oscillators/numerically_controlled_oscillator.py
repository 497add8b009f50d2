"""Oscillator whose phase is the integral of its frequency: turns[n+1] = turns[n] + T (frequency + gain control[n]).

The whole turns are taken off in each tick, and each tick of less than half a turn rounds by at most
2^-52 turns: after k ticks the phase is off by 2 pi k 2^-52 rad at most, 6 mrad after a year at 128
kHz. T is the period of the block. Outputs are offset-free: amplitude sin(2 pi turns), amplitude
cos(2 pi turns), and the phase itself. The
leading pair makes up for a delay of phase: half a tick for a force that is held.
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import cosine_of_turns, sine_of_turns
from proofmass.blocks.arithmetic.rounding import nearest_integer
from proofmass.blocks.declaration.declare import Block, Input, param


class NumericallyControlledOscillator(Block):
    """Sine and cosine of a frequency that a signal moves: of a phase-locked loop, a modulator, a slow sweep."""

    frequency: float = param("Hz", "Frequency without control.", default=8000.0)
    gain: float = param("Hz/({control_unit})", "Frequency per control.", default=1.0)
    amplitude: float = param("{unit}", "Peak value of sine and cosine.", default=1.0)
    initial_phase: float = param("rad", "Phase in tick 0.", default=0.0)
    lead: float = param("rad", "Angle by which the leading sine and cosine are ahead of the others.", default=0.0)
    control_unit: str = param("", "Unit of the control.", default="Hz")
    unit: str = param("", "Unit of sine and cosine.", default="1")

    control = Input("{control_unit}", "Control of the frequency.", default=0.0)


class State(NamedTuple):
    turns: float


class Constants(NamedTuple):
    turns: float  # in a tick, without control
    turns_per_control: float
    amplitude: float
    lead: float  # in turns


@NumericallyControlledOscillator.constants
def constants(p: NumericallyControlledOscillator, period: float) -> Constants:
    return Constants(p.frequency * period, p.gain * period, p.amplitude, p.lead / (2.0 * math.pi))


@NumericallyControlledOscillator.start
def start(p: NumericallyControlledOscillator) -> State:
    return State(p.initial_phase / (2.0 * math.pi))


@NumericallyControlledOscillator.output("{unit}")
def sine(c: Constants, x: State) -> float:
    """The sine of the phase."""
    return c.amplitude * sine_of_turns(x.turns)


@NumericallyControlledOscillator.output("{unit}")
def cosine(c: Constants, x: State) -> float:
    """The cosine of the phase."""
    return c.amplitude * cosine_of_turns(x.turns)


@NumericallyControlledOscillator.output("{unit}")
def leading_sine(c: Constants, x: State) -> float:
    """The sine of the phase and the lead."""
    return c.amplitude * sine_of_turns(x.turns + c.lead)


@NumericallyControlledOscillator.output("{unit}")
def leading_cosine(c: Constants, x: State) -> float:
    """The cosine of the phase and the lead."""
    return c.amplitude * cosine_of_turns(x.turns + c.lead)


@NumericallyControlledOscillator.output("rad")
def phase(c: Constants, x: State) -> float:
    """The phase, from -pi to pi."""
    return 2.0 * math.pi * (x.turns - nearest_integer(x.turns))


@NumericallyControlledOscillator.update
def update(c: Constants, x: State, control: float) -> State:
    turns = x.turns + (c.turns + c.turns_per_control * control)
    return State(turns - nearest_integer(turns))
