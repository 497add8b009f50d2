"""The quantiser: nearest level against numpy, its codes, and the noise of a fine one."""

import math

import numpy as np
import pytest

from proofmass.blocks import Quantiser
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.responses import noise, response


@pytest.mark.parametrize("levels", [2, 3, 5, 8, 257])
def test_the_nearest_of_the_levels(levels: int) -> None:
    signal = noise(1000, levels)
    grid = np.linspace(-1.5, 1.0, levels)
    block = Quantiser(levels=levels, lowest=-1.5, highest=1.0)
    codes = np.argmin(np.abs(np.subtract.outer(signal, grid)), axis=1)
    assert response(block, signal, "code") == codes.tolist()
    assert response(block, signal) == pytest.approx(grid[codes], abs=1e-15)


def test_three_levels_have_one_at_zero_and_four_have_none() -> None:
    assert response(Quantiser(), [-2.0, -0.4, 0.4, 0.6]) == [-1.0, 0.0, 0.0, 1.0]
    assert response(Quantiser(levels=4, lowest=-3.0, highest=3.0), [-0.1, 0.1, 9.0]) == [-1.0, 1.0, 3.0]


def test_the_noise_of_fine_steps_is_a_twelfth_of_their_square() -> None:
    block = Quantiser(levels=2001, lowest=-10.0, highest=10.0)
    signal = [9.0 * math.sin(0.7 * n + 0.01) for n in range(50_000)]
    errors = np.subtract(response(block, signal), signal)
    assert np.mean(errors**2) == pytest.approx(1e-4 / 12.0, rel=0.02)


def test_levels_in_the_wrong_order_are_refused() -> None:
    with pytest.raises(ModelError, match="less than highest = 1"):
        Quantiser(lowest=1.0)
