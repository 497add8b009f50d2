"""Rows times states and inputs, against sums of fractions."""

import random
from fractions import Fraction

from proofmass.blocks.arithmetic.eight_states import State, along, moved, padded


def test_a_row_times_states_and_inputs() -> None:
    """Numbers of few bits, so that no sum is rounded."""
    dice = random.Random(4)
    for _ in range(20):
        a, x, b, u = ([dice.randint(-999, 999) / 64 for _ in range(n)] for n in (8, 8, 4, 4))
        of_states = sum(Fraction(p) * Fraction(q) for p, q in zip(a, x, strict=True))
        of_inputs = sum(Fraction(p) * Fraction(q) for p, q in zip(b, u, strict=True))
        assert along(padded(a), State(*x)) == of_states
        assert moved(padded(a), (b[0], b[1], b[2], b[3]), State(*x), *u) == of_states + of_inputs


def test_a_short_row_ends_in_zeros() -> None:
    assert padded([]) == (0.0,) * 8
    assert padded([1.0, 2.0, 3.0]) == (1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0)
