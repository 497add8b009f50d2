"""The pulses: duty, number and place of their edges, both carriers."""

import numpy as np
import pytest

from proofmass.blocks import PulseWidthModulator
from tests.by_hand.responses import response


@pytest.mark.parametrize("triangular", [False, True])
@pytest.mark.parametrize("value", [-0.8, 0.0, 0.31, 1.0])
def test_the_duty_is_that_of_the_input(triangular: bool, value: float) -> None:
    block = PulseWidthModulator(frequency=1.0, triangular=triangular, low=0.0, high=3.0)
    answer = response(block, [value] * 40_960, period=2.0**-12)
    assert np.mean(answer) == pytest.approx(3.0 * 0.5 * (1.0 + value), abs=3.0 * 2.0 / 4096.0)
    assert np.count_nonzero(np.diff(answer)) == (20 if triangular else 19 if value < 1.0 else 0)


def test_edges_of_a_sawtooth_and_of_a_triangle_by_hand() -> None:
    """Eight ticks a period: carriers -1, -.75 ... .75 and -1, -.5, 0, .5, 1, .5, 0, -.5."""
    saw = response(PulseWidthModulator(frequency=0.125), [0.1] * 8)
    assert saw == [1.0, 1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0]
    triangle = response(PulseWidthModulator(frequency=0.125, triangular=True), [0.1] * 8)
    assert triangle == [1.0, 1.0, 1.0, -1.0, -1.0, -1.0, 1.0, 1.0]
