"""Slope of a swept gain: k = (sum dN_out dN - n mean(dN_out) mean(dN)) / (sum dN^2 - n mean(dN)^2).

Its deviation is k / k0 - 1. dN and dN_out are number and response less those of the first point of
the sweep, so that an offset of the response drops out (digital quartz accelerometer, section III.A,
eq. 17 to 21: k_pre-eq0, k_pre-eq1).
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class ForwardGainEstimator(Block):
    """Least-squares gain from swept number to response; the first sweep is the reference of those that follow."""

    reference: float = param("1", "Slope of the initial state, k0; 0: that of the first sweep.", default=0.0)

    number = Input("1", "Number that is swept, N_FPGA.")
    response = Input("1", "Averaged response to it, N_out.")
    read = Input("1", "Whether number and response are a point of the sweep.", dtype=bool)
    last = Input("1", "Whether the point is the last of its sweep.", dtype=bool)


class State(NamedTuple):
    points: int
    number: float  # of the first point
    response: float
    sum_number: float
    sum_response: float
    sum_squares: float
    sum_products: float
    slope: float
    reference: float
    estimated: bool


@ForwardGainEstimator.start
def start(p: ForwardGainEstimator) -> State:
    return State(0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, p.reference, False)


@ForwardGainEstimator.output("1")
def slope(p: ForwardGainEstimator, x: State) -> float:
    """Gain by the last whole sweep; zero before."""
    return x.slope


@ForwardGainEstimator.output("1")
def known_slope(p: ForwardGainEstimator, x: State) -> float:
    """Slope that deviations refer to; zero before it is known."""
    return x.reference


@ForwardGainEstimator.output("1")
def deviation(p: ForwardGainEstimator, x: State) -> float:
    """Relative deviation of the gain from its reference; zero before the first whole sweep."""
    return x.slope / x.reference - 1.0 if x.slope != 0.0 else 0.0


@ForwardGainEstimator.output("1")
def estimated(p: ForwardGainEstimator, x: State) -> bool:
    """True in the one tick from which on a new deviation is known."""
    return x.estimated


@ForwardGainEstimator.update
def update(p: ForwardGainEstimator, x: State, number: float, response: float, read: bool, last: bool) -> State:
    if not read:
        a, b, aa, ab = x.sum_number, x.sum_response, x.sum_squares, x.sum_products
        return State(x.points, x.number, x.response, a, b, aa, ab, x.slope, x.reference, False)
    n = x.points + 1
    first_number, first_response = (number, response) if n == 1 else (x.number, x.response)
    a, b = number - first_number, response - first_response
    sa, sb, saa, sab = x.sum_number + a, x.sum_response + b, x.sum_squares + a * a, x.sum_products + a * b
    if not last:
        return State(n, first_number, first_response, sa, sb, saa, sab, x.slope, x.reference, False)
    spread = saa - sa * sa / float(n)
    found = (sab - sa * sb / float(n)) / spread if spread > 0.0 else 0.0
    known = x.reference != 0.0
    return State(0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, found, x.reference if known else found, known)
