"""Least-squares slope in registers: deviation = sum (2 i - n + 1) y_i / S - 1 over an even sweep of n points.

ForwardGainEstimator with the sweep known beforehand: numbers that are `step` apart have small
integers as weights, and S = k0 step n (n^2 - 1) / 6 is a constant, so that nothing is divided; an
offset of the response drops out, since the weights add up to zero (digital quartz accelerometer,
section III.A, eq. 17 to 21).
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding, fixed
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedSlopeEstimator(Block):
    """Relative deviation of a swept gain from its reference, in fixed point."""

    points: int = param("1", "n, points of the sweep.", default=16, at_least=2, at_most=256)
    step: float = param("1", "From one number of the sweep to the next.", default=0.125, above=0.0)
    reference: float = param("1", "Slope of the initial state, k0.", default=1.0, above=0.0)
    input_format: Fixed = param("1", "Format of the response.", default=Fixed(24, 20))
    scale_format: Fixed = param("1", "Format of 1 / S.", default=Fixed(24, 28))
    output_format: Fixed = param("1", "Format of the deviation.", default=Fixed(24, 23))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of the deviation.", default="saturate")

    response = Input("1", "Averaged response to a number of the sweep.", dtype=FixedValue)
    read = Input("1", "Whether the response is the next point of the sweep.", dtype=bool)


class State(NamedTuple):
    point: FixedValue
    total: FixedValue
    deviation: FixedValue
    estimated: bool


class Constants(NamedTuple):
    scale: FixedValue


def point_format(p: FixedSlopeEstimator) -> Fixed:
    """Format of the number of a point."""
    return Fixed((p.points - 1).bit_length(), signed=False)


def total_format(p: FixedSlopeEstimator) -> Fixed:
    """Format of a sum no sweep overflows: the sizes of the weights add up to at most n^2 / 2."""
    return Fixed(p.input_format.width + (p.points**2 // 2).bit_length(), p.input_format.fraction)


@FixedSlopeEstimator.formats
def formats(p: FixedSlopeEstimator) -> dict[str, Fixed]:
    return {
        "response": p.input_format,
        "c.scale": p.scale_format,
        "x.point": point_format(p),
        "x.total": total_format(p),
        "x.deviation": p.output_format,
        "deviation": p.output_format,
    }


@FixedSlopeEstimator.constants
def constants(p: FixedSlopeEstimator, period: float) -> Constants:
    n = p.points
    return Constants(fixed(6.0 / (p.reference * p.step * n * (n * n - 1)), p.scale_format, "half_even"))


@FixedSlopeEstimator.output("1")
def deviation(p: FixedSlopeEstimator, x: State) -> FixedValue:
    """Slope by the last whole sweep over its reference, less one; zero before."""
    return x.deviation


@FixedSlopeEstimator.output("1")
def estimated(p: FixedSlopeEstimator, x: State) -> bool:
    """True in the one tick from which on a new deviation is known."""
    return x.estimated


@FixedSlopeEstimator.update
def update(c: Constants, p: FixedSlopeEstimator, x: State, response: FixedValue, read: bool) -> State:
    if not read:
        return State(x.point, x.total, x.deviation, False)
    weight = 2 * x.point - (p.points - 1)
    total = (x.total + weight * response).to(total_format(p))
    if x.point < p.points - 1:
        return State((x.point + 1).to(point_format(p)), total, x.deviation, False)
    found = (total * c.scale - 1).to(p.output_format, p.rounding, p.overflow)
    return State(FixedValue(0), FixedValue(0, p.input_format.fraction), found, True)
