"""Estimated impulse responses against the response that was convolved with the chips."""

from typing import Any

import numpy as np
import pytest

from proofmass.blocks import ImpulseResponseEstimator, ShiftRegister
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive

RESPONSE = np.array([0.0, 6.3, 1.7, -0.4, 0.11, -0.03])


def estimates(block: ImpulseResponseEstimator, offset: float = 0.0, periods: int = 2) -> Any:
    bits = [row["bit"] for row in drive(ShiftRegister(), [{}] * (1023 * periods + 1))]
    signs = 2.0 * np.array(bits) - 1.0
    answer = np.convolve(signs, RESPONSE)[: len(bits)] + offset
    rows = drive(block, [{"bit": b, "response": y} for b, y in zip(bits, answer.tolist(), strict=True)])
    return np.array([row["impulse_response"] for row in rows[::1023]])


def test_the_tail_takes_the_constant_and_an_offset_off() -> None:
    found = estimates(ImpulseResponseEstimator(cells=16, tail=8), offset=3.0)
    assert found[2] == pytest.approx([*RESPONSE, *[0.0] * 10], abs=1e-12)
    assert found[0].tolist() == [0.0] * 16


def test_without_a_tail_the_constant_of_the_autocorrelation_is_left() -> None:
    """Sarraf et al. 2012, eq. 2 and 3: the sums are (N + 1) h[k] - sum of h, and an offset adds 1 to each of N."""
    found = estimates(ImpulseResponseEstimator(cells=8), offset=3.0)
    expected = [*RESPONSE, 0.0, 0.0] + (3.0 - RESPONSE.sum()) / 1024.0
    assert found[2] == pytest.approx(expected, abs=1e-12)


def test_the_first_period_is_the_sum_over_the_chips_there_are() -> None:
    bits, answer = [True, False, False, True], [1.0, 2.0, 4.0, 8.0]
    block = ImpulseResponseEstimator(cells=3, chips=4)
    rows = drive(block, [{"bit": b, "response": y} for b, y in zip([*bits, True], [*answer, 0.0], strict=True)])
    assert rows[4]["impulse_response"] == [3.0 / 5.0, (2.0 - 4.0 - 8.0) / 5.0, (4.0 - 8.0) / 5.0]


def test_a_tail_of_all_cells_is_refused() -> None:
    with pytest.raises(ModelError, match="less than cells = 4"):
        ImpulseResponseEstimator(cells=4, tail=4)


@pytest.mark.parametrize(("tail", "expected"), [(1, [7.0, -6.0, 0.0]), (2, [10.0, -3.0, 3.0])])
def test_the_tail_is_the_last_cells_and_their_mean(tail: int, expected: list[float]) -> None:
    """Sums of 3, -10 and -4 over four chips: the last one, or the mean of the last two, is taken off all."""
    bits, answer = [True, False, False, True, True], [1.0, 2.0, 4.0, 8.0, 0.0]
    block = ImpulseResponseEstimator(cells=3, chips=4, tail=tail)
    rows = drive(block, [{"bit": b, "response": y} for b, y in zip(bits, answer, strict=True)])
    assert rows[4]["impulse_response"] == [value / 5.0 for value in expected]
