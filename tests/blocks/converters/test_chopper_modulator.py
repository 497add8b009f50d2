"""Two choppers around an amplifier with an offset: the signal comes back, the offset becomes a ripple."""

import pytest

from proofmass.blocks import ChopperModulator
from tests.by_hand.responses import noise, response


def test_the_square_wave() -> None:
    assert response(ChopperModulator(half_period=3), [0.0] * 8, "square") == [1.0] * 3 + [-1.0] * 3 + [1.0] * 2
    assert response(ChopperModulator(), [2.0, 3.0, 4.0]) == [2.0, -3.0, 4.0]


@pytest.mark.parametrize("half", [1, 5])
def test_an_offset_between_two_choppers_has_no_mean(half: int) -> None:
    signal = noise(40 * half)
    amplified = [10.0 * u + 0.5 for u in response(ChopperModulator(half_period=half), signal)]
    answer = response(ChopperModulator(half_period=half), amplified)
    rest = [y - 10.0 * u for y, u in zip(answer, signal, strict=True)]
    assert rest == pytest.approx(([0.5] * half + [-0.5] * half) * 20, abs=1e-14)
