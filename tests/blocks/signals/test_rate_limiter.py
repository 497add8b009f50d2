"""The rate limiter: slopes of a step, and what is slower passes."""

import itertools
import math

import pytest

from proofmass.blocks import RateLimiter
from tests.by_hand.responses import response


def test_a_step_up_and_down_by_hand() -> None:
    block = RateLimiter(rising=2.0, falling=4.0, initial=1.0)
    assert response(block, [1.0, 4.0, 4.0, 4.0, 0.0, 0.0, 0.0], period=0.5) == [1.0, 2.0, 3.0, 4.0, 2.0, 0.0, 0.0]


def test_a_slow_sine_passes_and_a_fast_one_becomes_a_triangle() -> None:
    times = [n * 1e-3 for n in range(2000)]
    slow = [math.sin(2.0 * math.pi * t) for t in times]
    assert response(RateLimiter(rising=6.3, falling=6.3), slow, period=1e-3) == slow
    fast = [math.sin(2.0 * math.pi * 20.0 * t) for t in times]
    answer = response(RateLimiter(rising=2.0, falling=2.0), fast, period=1e-3)
    assert {round(abs(b - a) / 1e-3, 6) for a, b in itertools.pairwise(answer)} >= {2.0}
    assert max(abs(b - a) for a, b in itertools.pairwise(answer)) <= 2.0e-3 * (1.0 + 1e-12)


def test_it_starts_from_its_initial_value() -> None:
    assert response(RateLimiter(rising=1.0), [10.0, 10.0]) == [1.0, 2.0]
    assert response(RateLimiter(initial=-3.0), [-3.0]) == [pytest.approx(-3.0)]
