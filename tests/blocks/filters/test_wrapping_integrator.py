"""The integral modulo its range, against exact fractions."""

import math
from fractions import Fraction

import pytest

from proofmass.blocks import WrappingIntegrator
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.responses import noise, response


def test_against_exact_fractions() -> None:
    signal = [round(64.0 * u) / 64.0 for u in noise(2000, 1, 5.0)]
    block = WrappingIntegrator(gain=0.5, lowest=-1.0, highest=2.0, initial=0.25)
    total = Fraction(1, 4)
    for y, wraps, u in zip(response(block, signal), response(block, signal, "wraps"), signal, strict=True):
        turns = math.floor((total + 1) / 3)
        assert (Fraction(y), wraps) == (total - 3 * turns, turns)
        total += Fraction(u) / 2


def test_a_phase_stays_exact_for_as_long_as_it_runs() -> None:
    """2^-7 turns a tick: where it comes to the end of the range it is at the start."""
    block = WrappingIntegrator(lowest=0.0, highest=1.0)
    answer = response(block, [2.0**-7] * 1000)
    assert answer == [(n % 128) / 128.0 for n in range(1000)]


def test_a_start_outside_is_refused() -> None:
    with pytest.raises(ModelError, match="to less than 1"):
        WrappingIntegrator(lowest=0.0, highest=1.0, initial=1.0)


def test_more_turns_than_a_number_can_count_end_the_run() -> None:
    """In one tick, or one after the other; integers of any size never come of it."""
    block = WrappingIntegrator(lowest=0.0, highest=1.0)
    assert response(block, [2.0**52, 0.0], "wraps") == [0, 2**52]
    for inputs in ([1e200, 0.0], [-1e17, 0.0], [2.0**52, 2.0**52, 2.0**52, 0.0]):
        assert math.isnan(response(block, inputs)[-1])
        assert response(block, inputs, "wraps")[-1] == 0
