"""Crossovers and peaks of sampled loops by a grid about their poles: against a grid of thirty thousand points."""

import math
from fractions import Fraction

import flint
import mpmath
import numpy as np
import pytest

from proofmass.runner.analysis.linearisation.rational import Transfer
from proofmass.runner.analysis.margins.swept import SweptAxis
from tests.by_hand.amounts import amounts
from tests.by_hand.axis_by_grid import ByGrid, random_loops
from tests.by_hand.axis_questions import compared


def axis_of(above: list[int], below: list[int]) -> SweptAxis:
    return SweptAxis(
        Transfer(flint.fmpz_poly(above), flint.fmpz_poly(below)), list(ByGrid(above, below, True).closed_poles())
    )


@pytest.mark.parametrize("count", amounts(10, 40))
def test_random_loops(count: int) -> None:
    for loop in random_loops(True, count):
        compared(axis_of(loop.above, loop.below), loop, rel=1e-7)


BELOW, NARROW = 2**40, 2**16  # D = z^2 - a z + 1 - 2^-24, over 2^-40: a pair of poles next to the circle


def resonance(above: int, a: float) -> SweptAxis:
    return axis_of([above], [BELOW - NARROW, -int(a * BELOW), BELOW])


@pytest.mark.parametrize("a", [0.5, -0.5, -1.5])
def test_poles_that_a_gain_brings_next_to_the_circle(a: float) -> None:
    """z^2 - a z + 1 - 2^-24 + f 2^-24 has a pair of poles, inside where f < 1."""
    for axis, scale in ((resonance(NARROW, a), 1.0), (resonance(NARROW << 10, a), 2.0**-10)):
        assert axis.outside(0.999 * scale) == 0
        assert axis.outside(1.001 * scale) == 2
        assert axis.outside(1.0 * scale) == 2, "on the circle, which is not inside"


def test_crossovers_beside_a_sharp_resonance() -> None:
    """|D|^2 = 4 b x^2 - 2 a (1 + b) x + 1 + a^2 + b^2 - 2 b with x = cos w: where it is k^2, |L| is 1."""
    a, b = Fraction(1, 2), 1 - Fraction(NARROW, BELOW)
    assert not resonance(NARROW // 2, 0.5).gain_crossings(), "its peak is 2 k / (2^-24 |2 sin w|) = 0.52"
    for times in (5, 60):
        rest = 1 + a * a + b * b - 2 * b - Fraction(times * NARROW, BELOW) ** 2
        crossings = resonance(times * NARROW, 0.5).gain_crossings()
        with mpmath.workdps(50):
            root = mpmath.sqrt((a * (1 + b)) ** 2 - 4 * b * rest)
            for crossing, sign in zip(crossings, (1, -1), strict=True):
                assert abs(crossing.w - mpmath.acos((a * (1 + b) + sign * root) / (4 * b))) < 1e-14


def test_a_grid_that_leaves_out_poles_on_the_circle() -> None:
    """z^2 - z + 1 has its roots at 60 degrees, where L is infinite: S is 0 there."""
    axis = axis_of([1], [10, -10, 10])
    w, _ = axis.largest(0)
    values = axis.values(axis._grid())
    assert np.isfinite(values).all()
    assert abs(w - math.pi / 3.0) > 0.1


@pytest.mark.parametrize("more", [0, 1, 10**6, -(10**6)])
def test_a_loop_that_begins_at_1(more: int) -> None:
    """L = (1 + e) / (10 z - 9): 181 - 180 cos w = (1 + e)^2. Next to rest, 10^-12 above 1 count as 1."""
    gain = 10**12 + more
    crossings = axis_of([gain], [-9 * 10**12, 10**13]).gain_crossings()
    truth = 2.0 * math.asin(math.sqrt(((gain / 10**12) ** 2 - 1.0) / 360.0)) if more > 1 else None
    assert [crossing.w for crossing in crossings] == ([pytest.approx(truth, rel=1e-9)] if truth else [])


def test_a_quotient_of_constants_has_no_degree() -> None:
    assert Transfer(flint.fmpz_poly([3]), flint.fmpz_poly([2])).degree == 0
    assert Transfer(flint.fmpz_poly([]), flint.fmpz_poly([])).degree == 0
    assert Transfer(flint.fmpz_poly([3]), flint.fmpz_poly([2, 1])).degree == 1
