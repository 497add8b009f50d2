"""Feedback gain by a switched current: D = mean N_on - mean N_off = -I_ref / (k_VI k_DA), deviation = D / D0 - 1.

The difference holds neither the acceleration nor the torquer's constant (digital quartz
accelerometer, section III.B, eq. 26 to 28). Its deviation is that of N, the column of Table 4; the
gain k_VI k_DA goes the other way, D0 / D - 1.
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class FeedbackGainEstimator(Block):
    """Difference of outputs with a reference current on and off; the first is the reference of those that follow."""

    reference: float = param("1", "Difference of the initial state, D0; 0: the first one.", default=0.0)

    response = Input("1", "Averaged output, N.")
    on = Input("1", "Whether the current was on.", dtype=bool)
    read = Input("1", "Whether the response counts.", dtype=bool)
    last = Input("1", "Whether it is the last of its measurement.", dtype=bool)


class State(NamedTuple):
    number_on: int
    number_off: int
    sum_on: float
    sum_off: float
    difference: float
    reference: float
    estimated: bool


@FeedbackGainEstimator.start
def start(p: FeedbackGainEstimator) -> State:
    return State(0, 0, 0.0, 0.0, 0.0, p.reference, False)


@FeedbackGainEstimator.output("1")
def difference(p: FeedbackGainEstimator, x: State) -> float:
    """N_on - N_off by the last whole measurement; zero before."""
    return x.difference


@FeedbackGainEstimator.output("1")
def known_difference(p: FeedbackGainEstimator, x: State) -> float:
    """Difference that deviations refer to; zero before it is known."""
    return x.reference


@FeedbackGainEstimator.output("1")
def deviation(p: FeedbackGainEstimator, x: State) -> float:
    """Relative deviation of the difference from its reference; zero before the first one."""
    return x.difference / x.reference - 1.0 if x.difference != 0.0 and x.reference != 0.0 else 0.0


@FeedbackGainEstimator.output("1")
def gain_deviation(p: FeedbackGainEstimator, x: State) -> float:
    """Relative deviation of the feedback gain from its reference."""
    return x.reference / x.difference - 1.0 if x.difference != 0.0 and x.reference != 0.0 else 0.0


@FeedbackGainEstimator.output("1")
def estimated(p: FeedbackGainEstimator, x: State) -> bool:
    """True in the one tick from which on a new deviation is known."""
    return x.estimated


@FeedbackGainEstimator.update
def update(p: FeedbackGainEstimator, x: State, response: float, on: bool, read: bool, last: bool) -> State:
    if not read:
        return State(x.number_on, x.number_off, x.sum_on, x.sum_off, x.difference, x.reference, False)
    ons, offs = x.number_on + (1 if on else 0), x.number_off + (0 if on else 1)
    sum_on, sum_off = x.sum_on + (response if on else 0.0), x.sum_off + (0.0 if on else response)
    if not last:
        return State(ons, offs, sum_on, sum_off, x.difference, x.reference, False)
    found = sum_on / float(ons) - sum_off / float(offs) if ons > 0 and offs > 0 else 0.0
    known = x.reference != 0.0
    return State(0, 0, 0.0, 0.0, found, x.reference if known else found, known)
