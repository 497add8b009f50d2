"""Times between edges of two sines against their phase, and the order of edges within ticks."""

import math

import pytest

from proofmass.blocks import TimeToDigital
from tests.by_hand.responses import responses


def sine(frequency: float, delay: float, period: float, samples: int) -> list[float]:
    return [math.sin(2.0 * math.pi * frequency * (n * period - delay)) for n in range(samples)]


@pytest.mark.parametrize("delay", [3.3e-6, 41.7e-6, 260e-6])
def test_the_delay_of_a_sine(delay: float) -> None:
    """Straight lines of a sine of 600 samples a period are off by less than 1e-5 of a period."""
    period, frequency = 1e-6, 1.0 / 600e-6
    signals = {"begin": sine(frequency, 33.3e-6, period, 3000), "end": sine(frequency, 33.3e-6 + delay, period, 3000)}
    block = TimeToDigital(resolution=1e-10)
    code = responses(block, "code", period, **signals)[-1]
    assert code * 1e-10 == pytest.approx(delay, abs=6e-9)
    assert responses(block, "interval", period, **signals)[-1] == pytest.approx(code * 1e-10)
    assert responses(block, "measurements", period, **signals)[-1] in (4, 5)


def test_edges_between_samples() -> None:
    """Straight lines with edges at 1.25, 4.5; 1.75, 4.25, 5.5 ticks: codes of a quarter tick round down."""
    begin = [-1.0, -0.25, 0.75, -1.0, -0.5, 0.5, 1.0]
    end = [-1.0, -0.75, 0.25, -1.0, -0.25, 0.75, 1.0]
    block = TimeToDigital(resolution=0.1)
    assert responses(block, "code", begin=begin, end=end) == [0, 0, 0, 5, 5, 5, 5]
    assert responses(block, "measurements", begin=begin, end=end)[-1] == 1


def test_an_end_before_a_new_begin_in_one_tick() -> None:
    """Time from 0.5; it ends at 2.25, and the next begins at 2.75 and ends at 4.5."""
    begin, end = [-1.0, 1.0, -3.0, 1.0, 1.0, 1.0, 1.0], [-1.0, -1.0, -1.0, 3.0, -1.0, 1.0, 1.0]
    block = TimeToDigital(resolution=0.25)
    assert responses(block, "code", begin=begin, end=end) == [0, 0, 0, 0, 7, 7, 7]
    assert responses(block, "measurements", begin=begin, end=end) == [0, 0, 0, 0, 1, 1, 2]


def test_long_times_give_the_last_code() -> None:
    begin, end = [-1.0] + [1.0] * 60, [-1.0] * 60 + [1.0]
    assert responses(TimeToDigital(resolution=1.0, bits=4), "code", begin=[*begin, 1.0], end=[*end, 1.0])[-1] == 15
