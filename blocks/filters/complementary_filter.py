"""Complementary filter: y[n] = a (y[n-1] + T slope[n]) + (1 - a) reference[n], a = tau / (tau + T).

High-pass for the integral of the slope, low-pass for the reference, and the sum of both is 1
(Higgins, A comparison of complementary and Kalman filtering, IEEE Trans. Aerospace and Electronic
Systems 11, 1975).
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class ComplementaryFilter(Block):
    """Joins a fast sensor of a rate with a slow one of the value: attitude from gyroscope and accelerometer."""

    time_constant: float = param("s", "Time over which the slope is trusted, tau.", default=1.0, above=0.0)
    initial: float = param("{unit}", "Estimate before tick 0.", default=0.0)
    unit: str = param("", "Unit of reference and estimate.", default="rad")

    slope = Input("({unit})/s", "Rate of change, right over short times.")
    reference = Input("{unit}", "Value, right over long times.")


class State(NamedTuple):
    estimate: float


class Constants(NamedTuple):
    period: float
    kept: float


@ComplementaryFilter.constants
def constants(p: ComplementaryFilter, period: float) -> Constants:
    return Constants(period, p.time_constant / (p.time_constant + period))


@ComplementaryFilter.start
def start(p: ComplementaryFilter) -> State:
    return State(p.initial)


@ComplementaryFilter.output("{unit}")
def estimate(c: Constants, x: State, slope: float, reference: float) -> float:
    """The estimate from both."""
    return c.kept * (x.estimate + c.period * slope) + (1.0 - c.kept) * reference


@ComplementaryFilter.update
def update(c: Constants, x: State, slope: float, reference: float) -> State:
    return State(c.kept * (x.estimate + c.period * slope) + (1.0 - c.kept) * reference)
