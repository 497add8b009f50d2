"""The filter: a known angle from both inputs, the noise of each by scipy.signal."""

import numpy as np
from scipy import signal

from proofmass.blocks import ComplementaryFilter
from tests.by_hand.responses import distance, noise, responses

PERIOD, TAU = 1e-2, 0.5
KEPT = TAU / (TAU + PERIOD)


def test_each_input_has_its_transfer_function() -> None:
    u, zero = noise(400), [0.0] * 400
    block = ComplementaryFilter(time_constant=TAU)
    by_slope = responses(block, "estimate", PERIOD, slope=u, reference=zero)
    assert distance(by_slope, signal.lfilter([KEPT * PERIOD], [1.0, -KEPT], u)) < 1e-12
    by_reference = responses(block, "estimate", PERIOD, slope=zero, reference=u)
    assert distance(by_reference, signal.lfilter([1.0 - KEPT], [1.0, -KEPT], u)) < 1e-12


def test_a_motion_that_both_see_comes_out_as_it_is() -> None:
    angles = np.cumsum(noise(500)) * PERIOD
    slopes = np.diff([0.0, *angles]) / PERIOD
    answer = responses(
        ComplementaryFilter(time_constant=TAU), "estimate", PERIOD, slope=slopes.tolist(), reference=angles.tolist()
    )
    assert distance(answer, angles) < 1e-12
