"""The hold against numpy.interp and numpy's extrapolation by hand."""

import numpy as np
import pytest

from proofmass.blocks import FirstOrderHold
from tests.by_hand.responses import noise, response


@pytest.mark.parametrize("ratio", [1, 2, 7])
def test_delayed_it_joins_the_samples(ratio: int) -> None:
    samples = noise(30)
    steps = [u for u in samples for _ in range(ratio)]
    answer = response(FirstOrderHold(ratio=ratio, delayed=True), steps)
    ticks = np.arange(len(steps)) / ratio - 1.0
    assert answer == pytest.approx(np.interp(ticks, np.arange(-1, 30), [0.0, *samples]), abs=1e-14)


def test_ahead_it_goes_on_as_between_the_last_samples() -> None:
    samples = noise(30)
    answer = np.reshape(response(FirstOrderHold(ratio=4), np.repeat(samples, 4).tolist()), (30, 4))
    slopes = np.diff([0.0, *samples])
    assert answer == pytest.approx(np.add(np.array(samples)[:, None], np.outer(slopes, np.arange(4) / 4)), abs=1e-14)


def test_a_ramp_is_held_without_error() -> None:
    ramp = [3.0 * (n // 5 * 5) for n in range(50)]
    assert response(FirstOrderHold(ratio=5), ramp)[5:] == pytest.approx([3.0 * n for n in range(5, 50)], rel=1e-14)
