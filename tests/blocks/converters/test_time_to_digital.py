"""Times between edges of two sines against their phase, and the order of edges within ticks."""

import math
import random
from fractions import Fraction

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


@pytest.mark.derivation(
    TimeToDigital,
    equation="code = floor(t / resolution)",
    source="instants of edges on straight lines in exact fractions, a hundred pairs at random",
    convention="floor, not the nearest: a code is half a step too low on the mean; an edge rises through zero",
)
def test_random_edges_in_exact_fractions() -> None:
    source, begin, end, expected = random.Random(5), [-1.0], [-1.0], []
    for _ in range(100):
        first, wait, second = source.randrange(1, 64), source.randrange(1, 6), source.randrange(1, 64)
        begin += [float(Fraction(64, first) - 1), *[1.0] * wait, -1.0]  # from -1 it crosses zero at first / 64
        end += [-1.0] * wait + [float(Fraction(64, second) - 1), -1.0]
        expected.append((wait + Fraction(second - first, 64)) * Fraction(1, 10**6) // Fraction(1, 10**8))
    signals = {"begin": [*begin, -1.0], "end": [*end, -1.0]}
    block = TimeToDigital(resolution=1e-8)
    codes, count = responses(block, "code", 1e-6, **signals), responses(block, "measurements", 1e-6, **signals)
    found = {n: code for n, code in zip(count, codes, strict=True) if n}
    assert [abs(found[n + 1] - code) <= (code * 64 % 64 == 0) for n, code in enumerate(expected)] == [True] * 100
