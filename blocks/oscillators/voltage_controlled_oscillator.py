"""Voltage-controlled oscillator: turns' = frequency + gain control; sine = amplitude sin(2 pi turns); continuous.

A NumericallyControlledOscillator does the same at ticks. The turns of a tick are exact where the
control is held, or comes from linear blocks; else they have the accuracy of the integration. The
whole turns are counted apart in each tick, which rounds by some 2^-53 of the turns in it, or of
one: after k ticks sine and cosine are off by about 2 pi k 2^-53 rad, however many turns there were.
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import nearest_integer
from proofmass.blocks.declaration.declare import Block, Input, param
from proofmass.blocks.oscillators.numerically_controlled_oscillator import cosine, sine


class VoltageControlledOscillator(Block):
    """Analog oscillator whose frequency a voltage moves between ticks, too: of an analog phase-locked loop."""

    frequency: float = param("Hz", "Frequency without control.", default=8000.0)
    gain: float = param("Hz/({control_unit})", "Frequency per control.", default=1000.0)
    amplitude: float = param("{unit}", "Peak value of sine and cosine.", default=1.0)
    initial_phase: float = param("rad", "Phase at the start.", default=0.0)
    control_unit: str = param("", "Unit of the control.", default="V")
    unit: str = param("", "Unit of sine and cosine.", default="V")

    control = Input("{control_unit}", "Control of the frequency.")


class State(NamedTuple):
    turns: float  # from -1/2 to 1/2 at each tick
    whole: float  # turns that were taken off


@VoltageControlledOscillator.start
def start(p: VoltageControlledOscillator) -> State:
    turns = p.initial_phase / (2.0 * math.pi)
    return State(turns - nearest_integer(turns), nearest_integer(turns))


VoltageControlledOscillator.output("{unit}")(sine)
VoltageControlledOscillator.output("{unit}")(cosine)


@VoltageControlledOscillator.output("rad")
def phase(p: VoltageControlledOscillator, x: State) -> float:
    """The phase since the start, whole turns included."""
    return 2.0 * math.pi * (x.whole + x.turns)


@VoltageControlledOscillator.derivative(linear=True)
def derivative(p: VoltageControlledOscillator, x: State, control: float) -> State:
    return State(p.frequency + p.gain * control, 0.0)


@VoltageControlledOscillator.fold
def fold(p: VoltageControlledOscillator, x: State) -> State:
    whole = nearest_integer(x.turns)
    return State(x.turns - whole, x.whole + whole)
