"""Synthetic readings of two accelerometers, built so that compensation does what Liu, Li and Shen report of M1 and M2.

V = scale (exp(b1 (T - 0.6 V)) + f exp(b2 (T - 1.8 V))) + amplitude (2 frac(i / golden ratio) - 1), i = 1 to 61, without
a random generator. The paper gives no readings.
"""

import functools
import math
from typing import Any, NamedTuple

import numpy as np

from proofmass.runner.design.fit.data import Readings
from proofmass.runner.design.fit.fit import FitReport, fit

TEMPERATURE = np.linspace(0.6, 1.8, 61)


class Device(NamedTuple):
    """How a set is built, and what the paper and an independent computation say of it."""

    exponents: tuple[float, float]
    second: float  # size of the second exponential against the first
    scale: float
    amplitude: float
    before: float  # peak to peak, paper
    after: float  # peak to peak, paper
    rmse: tuple[float, float, float]  # two exponentials, 3rd order, 4th order
    r_squared: tuple[float, float, float]
    iterations: int  # of the alternation from (-1, 1)
    rate: float

    def law(self) -> dict[str, float]:
        """The two exponentials without the residual, at zero volts."""
        (b1, b2), scale = self.exponents, self.scale
        return {
            "a1": scale * math.exp(-0.6 * b1),
            "b1": b1,
            "a2": scale * self.second * math.exp(-1.8 * b2),
            "b2": b2,
        }

    def output(self) -> Any:
        """The zero bias at each temperature."""
        falling, rising = self.exponents
        law = np.exp(falling * (TEMPERATURE - 0.6)) + self.second * np.exp(rising * (TEMPERATURE - 1.8))
        spread = 2.0 * ((0.6180339887498949 * np.arange(1, 62)) % 1.0) - 1.0
        return self.scale * law + self.amplitude * spread

    def readings(self) -> Readings:
        """The set as readings."""
        return Readings("made", TEMPERATURE, self.output(), "sensor", "zero bias", "V", "V")


M1 = Device(
    exponents=(-6.0, 1.5),
    second=1.0,
    scale=0.00482055097,
    amplitude=0.000190759416,
    before=3.9e-3,
    after=3.6871e-4,
    rmse=(1.0919e-4, 1.8157e-4, 1.2120e-4),
    r_squared=(0.98771, 0.96603, 0.98486),
    iterations=3016,
    rate=0.9960,
)
M2 = Device(
    exponents=(-3.0, 2.0),
    second=0.35,
    scale=0.00229740818,
    amplitude=9.53537064e-5,
    before=1.9e-3,
    after=1.8413e-4,
    rmse=(5.4581e-5, 5.7064e-5, 5.4785e-5),
    r_squared=(0.98660, 0.98536, 0.98650),
    iterations=7918,
    rate=0.9983,
)
DEVICES = {"m1": M1, "m2": M2}


@functools.cache
def fitted(device: Device, start: tuple[float, float] | None = None) -> FitReport:
    """The report on a set; its alternation of thousands of turns takes most of a second."""
    return fit(device.readings(), start=start)
