"""The delay against a list that is shifted."""

import pytest

from proofmass.blocks import Delay
from tests.by_hand.responses import noise, response


@pytest.mark.parametrize("ticks", [1, 2, 7, 1000])
def test_the_input_so_many_ticks_before(ticks: int) -> None:
    signal = noise(300)
    assert response(Delay(ticks=ticks, initial=-2.5), signal) == ([-2.5] * ticks + signal)[:300]


def test_it_breaks_a_loop() -> None:
    assert Delay.feedthrough("output") == ()
