"""Photodetector: current = I + s n, I = L + dark_current, L = responsivity power, s^2 = (2 e I + L^2 r) fs / 2.

2 e I is the one-sided density of shot noise, r that of relative intensity noise, of the light
alone; fs is the rate of the block, n standard normal. Both are white and independent, and so is
their sum (Saleh and Teich, Fundamentals of Photonics, chapter 19).
"""

import math
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param

ELEMENTARY_CHARGE = 1.602176634e-19  # C, exact in the SI


class Photodetector(Block):
    """Photodiode with shot noise and the intensity noise of its source."""

    responsivity: float = param("A/W", "Current per power.", default=0.9, above=0.0)
    dark_current: float = param("A", "Current without light.", default=1e-9, at_least=0.0)
    intensity_noise: float = param(
        "1/Hz", "One-sided density of relative intensity noise, r.", default=0.0, at_least=0.0
    )
    noisy: bool = param("", "Whether there is noise.", default=True)

    power = Input("W", "Light on the detector; none below zero.")


class Constants(NamedTuple):
    responsivity: float
    dark_current: float
    shot: float
    relative: float


@Photodetector.constants
def constants(p: Photodetector, period: float) -> Constants:
    band = 0.5 / period if p.noisy else 0.0
    return Constants(p.responsivity, p.dark_current, 2.0 * ELEMENTARY_CHARGE * band, p.intensity_noise * band)


@Photodetector.output("A")
def current(c: Constants, power: float, normal: float) -> float:
    """The photocurrent."""
    light = c.responsivity * (power if power > 0.0 else 0.0)
    mean = light + c.dark_current
    variance = c.shot * mean + c.relative * light * light
    return mean + math.sqrt(variance) * normal if variance > 0.0 else mean
