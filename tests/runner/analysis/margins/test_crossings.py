"""Crossovers and peaks by certified roots: against a dense grid, and where closed forms are known."""

import math

import flint
import numpy as np
import pytest

from proofmass.runner.analysis.linearisation.rational import Transfer
from proofmass.runner.analysis.margins.axis import CertifiedAxis
from tests.by_hand.amounts import amounts
from tests.by_hand.axis_by_grid import random_loops
from tests.by_hand.axis_questions import compared


def axis_of(above: list[int], below: list[int], sampled: bool = True) -> CertifiedAxis:
    return CertifiedAxis(Transfer(flint.fmpz_poly(above), flint.fmpz_poly(below)), sampled)


@pytest.mark.exhaustive("True")
@pytest.mark.parametrize("count", amounts(20, 40))
@pytest.mark.parametrize("sampled", [False, True])
def test_random_loops(sampled: bool, count: int) -> None:
    for loop in random_loops(sampled, count):
        compared(axis_of(loop.above, loop.below, sampled), loop)


def test_an_integrator() -> None:
    """L = k / (z - 1): |L| = 1 at 2 asin(k / 2), lag pi / 2 - w / 2, and -k / 2 at half the rate, as |S| is largest."""
    axis = axis_of([1], [-2, 2])
    (crossing,) = axis.gain_crossings()
    w = 2.0 * math.asin(0.25)
    assert (crossing.w, crossing.size, crossing.lag) == pytest.approx((w, 1.0, 0.5 * math.pi - 0.5 * w), rel=1e-15)
    (last,) = axis.phase_crossings()
    assert (last.w, last.size, last.lag) == (math.pi, 0.25, 0.0)
    assert axis.end() == last
    assert axis.rest() is None
    assert axis.largest(0) == pytest.approx((math.pi, 1.0 / 0.75))
    assert axis.largest(1) == pytest.approx((math.pi, 1.25 / 0.75))
    cosine = 1.0 - 0.25 / 1.0  # |T|^2 = k^2 / |z - 1 + k|^2 = 1/2, k = 1/2: 1.25 - cos w = 0.5
    assert axis.fall() == pytest.approx(math.acos(cosine), rel=1e-15)


def test_a_continuous_double_lag() -> None:
    """L = -8 / (s + 1)^2 as positive feedback, and 3 / (s (s + 1)^2): phase -180 deg at 1 rad/s, where |L| = 3/2."""
    axis = axis_of([3], [0, 1, 2, 1], sampled=False)
    (crossing,) = axis.phase_crossings()
    assert (crossing.w, crossing.size, crossing.lag) == pytest.approx((1.0, 1.5, 0.0))
    last = axis.end()
    assert last is not None
    assert (last.w, last.size) == (math.inf, 0.0)
    positive = axis_of([-8], [1, 2, 1], sampled=False)
    rest = positive.rest()
    assert rest is not None
    assert (rest.w, rest.size, rest.lag) == (0.0, 8.0, 0.0)
    (gain,) = positive.gain_crossings()
    assert (gain.w, gain.lag) == pytest.approx((math.sqrt(7.0), -2.0 * math.atan(math.sqrt(7.0))))


def test_a_pole_on_the_axis_has_no_largest_value() -> None:
    """1 + L = 0 at +-j 2, of L = 3 / (s^2 + 1): the first such frequency, and an infinite peak."""
    assert axis_of([3], [1, 0, 1], sampled=False).largest(0) == pytest.approx((2.0, math.inf))


def test_a_real_loop_crosses_nothing() -> None:
    """L = -2 everywhere, and L = k / (2 cos w - 5/2), which is real; half the rate counts if it is negative there."""
    assert [c.w for c in axis_of([-2], [1]).phase_crossings()] == [math.pi]
    assert axis_of([2], [1]).phase_crossings() == []
    (last,) = axis_of([0, 2], [2, -5, 2]).phase_crossings()
    assert (last.w, last.size) == pytest.approx((math.pi, 2.0 / 9.0))
    assert axis_of([0, -2], [2, -5, 2]).phase_crossings() == []


def test_where_a_loop_is_zero_or_infinite_it_has_no_sign() -> None:
    """(z^2 + 1)(z^2 - z + 1) / (10 z^2) is 0.1 (2 cos w)(2 cos w - 1): real, with zeros; so is its inverse with poles.

    Behind a delay of a sample more it turns by -w, and is negative at no w but 0 and pi, where it is 0.2 and -0.6.
    """
    zeros = np.polymul([1, 0, 1], [1, -1, 1])[::-1].tolist()
    assert axis_of(zeros, [0, 0, 10]).phase_crossings() == []
    for above, below, size in ((zeros, [0, 0, 0, 10], 0.6), ([0, 10], zeros, 10.0 / 6.0)):
        (last,) = axis_of(above, below).phase_crossings()
        assert (last.w, last.size) == pytest.approx((math.pi, size))


@pytest.mark.parametrize(("excess", "counted"), [(10**14, False), (10**11, True)])
def test_a_crossover_within_rounding_of_rest_does_not_count(excess: int, counted: bool) -> None:
    """L = (1 + 1 / excess) / (1 + s): |L| = 1 at sqrt(2 / excess), and it is 1 but for rounding up to there."""
    axis = axis_of([excess + 1], [excess, excess], sampled=False)
    assert [c.w for c in axis.gain_crossings()] == pytest.approx([math.sqrt(2.0 / excess)] * counted, rel=1e-5)


def test_a_peak_between_rest_and_its_crossover_counts() -> None:
    """L = 1 / (s^2 + s / 5 + 1) is 1 at rest, and again at sqrt(2 - 1/25) after its peak."""
    axis = axis_of([5], [5, 1, 5], sampled=False)
    assert [c.w for c in axis.gain_crossings()] == pytest.approx([math.sqrt(2.0 - 0.04)], rel=1e-15)


def test_nothing_passes_at_rest() -> None:
    """T is 0 at rest with a zero there, and infinite with 1 + L = 0: neither falls by 3 dB."""
    assert axis_of([-1, 1], [0, 2]).fall() is None
    assert axis_of([-1], [1, 1], sampled=False).fall() is None
    assert axis_of([1], [3]).fall() is None


def test_values() -> None:
    (value,) = axis_of([1, 2], [3, 4, 5], sampled=False).values(np.array([0.7]))
    s = 0.7j
    assert value == pytest.approx((1 + 2 * s) / (3 + 4 * s + 5 * s * s), rel=1e-15)


@pytest.mark.parametrize(("millionths", "crossovers"), [(0.2, 1), (1.0, 0)])
def test_a_crossover_counts_if_the_gain_has_left_one_before_it(millionths: float, crossovers: int) -> None:
    """|L|^2 = (a - b y)^2 + c^2 y over (a (1 + y))^2, y = w^2, is 1 at y = 0 and at y = 1, and nowhere else.

    With a = m^2 + 1, b = m^2 - 4 m + 1 and c = 2 (m^2 - 1), |L| - 1 is about 4 y (1 - y) / (m (1 + y)^2) between. Of
    that 1e-12 is rounding: 0.039, 0.48 and 0.19 / m at 0.1, 0.5 and 0.9 rad/s.
    """
    m = round(millionths * 1e12)
    a, b, c = m * m + 1, m * m - 4 * m + 1, 2 * (m * m - 1)
    found = axis_of([a, c, b], [a, 2 * a, a], sampled=False).gain_crossings()
    assert [crossing.w for crossing in found] == pytest.approx([1.0] * crossovers)
