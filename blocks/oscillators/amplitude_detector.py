"""Amplitude detector: a[n] = a[n-1] + k (pi / 2 |u[n]| - a[n-1]), k = 1 - exp(-2 pi corner T).

pi / 2 of the mean of a rectified sine is its amplitude; the ripple of twice its frequency f is about
corner / (3 f) of it.
"""

import math
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class AmplitudeDetector(Block):
    """Rectifier and low-pass: the envelope of a carrier, without a reference."""

    corner_frequency: float = param("Hz", "Corner of the low-pass; far below the carrier.", default=10.0, above=0.0)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "A sine of slowly moving amplitude.")


class State(NamedTuple):
    amplitude: float


class Constants(NamedTuple):
    part: float
    rectified: float


@AmplitudeDetector.constants
def constants(p: AmplitudeDetector, period: float) -> Constants:
    part = -math.expm1(-2.0 * math.pi * p.corner_frequency * period)
    return Constants(part, 0.5 * math.pi)


@AmplitudeDetector.output("{unit}")
def amplitude(c: Constants, x: State, input: float) -> float:
    """The amplitude."""
    return x.amplitude + c.part * (c.rectified * abs(input) - x.amplitude)


@AmplitudeDetector.update
def update(c: Constants, x: State, input: float) -> State:
    return State(x.amplitude + c.part * (c.rectified * abs(input) - x.amplitude))
