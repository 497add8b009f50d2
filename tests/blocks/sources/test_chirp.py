"""The sweep against the integral of its frequency."""

import mpmath
import pytest

from proofmass.blocks import Chirp
from tests.by_hand.functions import drive


@pytest.mark.parametrize(("first", "last"), [(10.0, 400.0), (400.0, 0.0), (50.0, 50.0)])
def test_phase_is_the_integral_of_the_frequency(first: float, last: float) -> None:
    period, sweep = 1.0 / 1024.0, 0.75
    block = Chirp(amplitude=3.0, offset=0.5, start_frequency=first, stop_frequency=last, sweep_time=sweep, phase=0.3)
    for tick, row in enumerate(drive(block, [{}] * 1500, period)):
        time = mpmath.mpf(tick) / 1024
        inside = min(time, mpmath.mpf(sweep))
        turns = first * inside + (last - first) * inside**2 / (2 * sweep) + last * (time - inside)
        exact = 0.5 + 3.0 * mpmath.sinpi(2 * (turns + mpmath.mpf(0.3) / (2 * mpmath.pi)))
        assert abs(row["output"] - exact) < 4e-12


def test_a_sine_of_the_last_frequency_after_the_sweep() -> None:
    block = Chirp(start_frequency=0.0, stop_frequency=2.0, sweep_time=1.0)
    rows = drive(block, [{}] * 33, period=0.125)
    assert [row["output"] for row in rows[8:16:2]] == [0.0, 0.0, 0.0, 0.0]
    assert [row["output"] for row in rows[9:17:4]] == [1.0, 1.0]
