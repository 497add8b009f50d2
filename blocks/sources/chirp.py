"""Chirp source: a sine whose frequency goes linearly from f0 to f1 over the sweep time T, and then stays at f1.

Turns of phase since the start: f0 t + (f1 - f0) t^2 / (2 T) up to T, then f1 more per second; the
phase never jumps.
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import sine_of_turns
from proofmass.blocks.declaration.declare import Block, param

_PHASE = "the phase would not be the integral of the frequency: take a NumericallyControlledOscillator behind a Ramp"


class Chirp(Block):
    """A sine wave that sweeps through a band of frequencies once, to see a frequency response."""

    amplitude: float = param("{unit}", "Peak value about the offset.", default=1.0)
    start_frequency: float = param("Hz", "Frequency at the start.", default=10.0, at_least=0.0, not_driven=_PHASE)
    stop_frequency: float = param(
        "Hz", "Frequency from the end of the sweep on.", default=1000.0, at_least=0.0, not_driven=_PHASE
    )
    sweep_time: float = param("s", "Duration of the sweep.", default=1.0, above=0.0, not_driven=_PHASE)
    phase: float = param("rad", "Phase at the start.", default=0.0)
    offset: float = param("{unit}", "Mean value.", default=0.0)
    unit: str = param("", "Unit of the output.", default="1")


class Constants(NamedTuple):
    amplitude: float
    start_frequency: float
    half_slope: float
    sweep_time: float
    stop_frequency: float
    phase_in_turns: float
    offset: float


@Chirp.constants
def constants(p: Chirp, period: float) -> Constants:
    half_slope = (p.stop_frequency - p.start_frequency) / (2.0 * p.sweep_time)
    turns = p.phase / (2.0 * math.pi)
    return Constants(p.amplitude, p.start_frequency, half_slope, p.sweep_time, p.stop_frequency, turns, p.offset)


@Chirp.output("{unit}")
def output(c: Constants, time: float) -> float:
    """The swept sine wave."""
    swept = time if time < c.sweep_time else c.sweep_time
    turns = (c.start_frequency + c.half_slope * swept) * swept + c.stop_frequency * (time - swept)
    return c.offset + c.amplitude * sine_of_turns(turns + c.phase_in_turns)


@Chirp.corner
def swept_through(c: Constants, time: float) -> float:
    return time - c.sweep_time
