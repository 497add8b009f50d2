"""What bounded numbers reach in systems that decay, worked out by hand."""

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from proofmass.runner.design.proof import reach
from proofmass.runner.design.proof.digital_map import DigitalMap
from proofmass.runner.design.proof.digital_reach import DigitalReach
from proofmass.runner.design.proof.reach import Entering, Powers, extremes, responses
from proofmass.runner.fixed.affine import ERROR, REGISTER, AffineForms, RoundingError


def rows(*numbers: Any) -> list[list[Fraction]]:
    return [[Fraction(number) for number in row] for row in numbers]


def test_what_a_decaying_number_reaches() -> None:
    """Of h = 1, -1/2, 1/4 ...: 4/3 of the upper end and -2/3 of the lower one, and the other way round."""
    entering = Entering(rows([1], [0]), [(Fraction(-1, 2), Fraction(2))])
    found = extremes(Powers(rows([-0.5, 0], [0, 0.25])), entering, rows([1, 0], [-3, 0], [0, 1]))
    assert found is not None
    assert found.high == pytest.approx([3.0, 6.0, 0.0], abs=1e-8)
    assert found.low == pytest.approx([-2.0, -9.0, 0.0], abs=1e-8)
    assert (found.high[:2] > [3.0, 6.0]).all()
    assert (found.low[:2] < [-2.0, -9.0]).all()


def test_what_errors_do_not_move_has_no_part_in_what_they_reach() -> None:
    """x' = n + e, where n counts without end."""
    forms, half = AffineForms(), Fraction(1, 2)
    x, n, e = forms.symbol(REGISTER, 0), forms.symbol(REGISTER, 1), forms.symbol(ERROR, 0)
    found = DigitalReach(
        DigitalMap((0, 0), (n + e, n + 1), (), (), (RoundingError("x", -half, half),), (), {}, 1)
    ).of_errors(x)
    assert found is not None
    assert (found.low, found.high) == pytest.approx((-0.5, 0.5))


def test_two_inputs_add_up_and_each_has_its_ends() -> None:
    """Of 1/2 from 1 and from 3: 2 and 6 times the ends; nothing enters without columns."""
    ends = [(Fraction(-1), Fraction(2)), (Fraction(1), Fraction(4))]
    found = extremes(Powers(rows([0.5])), Entering(rows([1, 3]), ends), rows([1]))
    assert found is not None
    assert (found.low[0], found.high[0]) == pytest.approx((0.0, 28.0), abs=1e-8)
    assert found.low_at.tolist() == [0]
    assert found.high_at[0] > 30
    sizes = Entering(rows([1, 3]), [(Fraction(-3), Fraction(2)), ends[1]]).sizes()
    assert sizes == pytest.approx([3.0, 4.0])
    assert (sizes > [3.0, 4.0]).all()
    nothing = extremes(Powers(rows([1])), Entering(rows([]), []), rows([1], [2]))
    assert nothing is not None
    assert (nothing.low.tolist(), nothing.high.tolist()) == ([0.0, 0.0], [0.0, 0.0])
    assert extremes(Powers(rows([1])), Entering(rows([1]), ends[:1]), rows([1])) is None


def test_a_pulse_that_is_over_counts_once() -> None:
    """h = 0, 1, 0 ...: the largest is there after two values."""
    entering = Entering(rows([0], [1]), [(Fraction(-1), Fraction(2))])
    found = extremes(Powers(rows([0, 1], [0, 0])), entering, rows([1, 0]))
    assert found is not None
    assert (found.low[0], found.high[0]) == pytest.approx((-1.0, 2.0), abs=1e-9)
    assert (found.low_at.tolist(), found.high_at.tolist()) == ([2], [2])


def test_what_decays_slowly_is_added_up_over_several_chunks() -> None:
    """100 times 2, last reached where the powers end; 0.999^63 is 0.94, more than 0.9: no bound of the rest."""
    entering = Entering(rows([1]), [(Fraction(-1, 2), Fraction(2))])
    found = extremes(Powers(rows([0.99])), entering, rows([1]))
    assert found is not None
    assert (found.low[0], found.high[0]) == pytest.approx((-50.0, 200.0))
    assert found.high_at.item() > 2000


def test_powers_that_are_too_many_to_become_small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reach, "MOST_POWERS", 64)
    for pole, known in ((0.99, True), (0.999, False)):
        assert sum(map(len, Powers(rows([pole])).chunks())) == 64
        assert (Powers(rows([pole])).sums is not None) is known


def test_sums_of_powers() -> None:
    """1, 1/2 ... 2^-40 are 41 powers; of 0.99 there are 2759, in several chunks."""
    sums = Powers(rows([0.5])).sums
    assert sums is not None
    assert (sums.count, sums.last.item()) == (40, 2.0**-40)
    assert sums.sizes.item() == pytest.approx(2.0)
    assert 2.0**-40 <= sums.norm < 2.0**-39
    slow = Powers(rows([0.99])).sums
    assert slow is not None
    assert slow.count == math.ceil(40.0 * math.log(2.0) / -math.log(0.99))
    assert slow.sizes.item() == pytest.approx(100.0, rel=1e-9)
    assert 0.0 < slow.error < 1e-9
    for growing in (1.0, -1.0, 1.5, 1.0 - 1e-8):
        assert Powers(rows([growing])).sums is None
    skew = Powers(rows([0.5, 2**20], [0, 0.25]))
    assert skew.radius == pytest.approx(0.5)
    assert skew.sums is not None


def test_responses_of_some_powers(monkeypatch: pytest.MonkeyPatch) -> None:
    powers, entering = Powers(rows([0.9, 1], [0, 0.25])), Entering(rows([1], [2]), [(Fraction(0), Fraction(1))])
    a = np.array([[0.9, 1.0], [0.0, 0.25]])
    wanted = [float(np.array([3.0, 5.0]) @ np.linalg.matrix_power(a, m) @ [1.0, 2.0]) for m in range(200)]
    for most in (1, 5, 64, 70):
        parts = list(responses(powers, entering, rows([3, 5]), most))
        found = np.concatenate(parts).ravel()
        assert found == pytest.approx(wanted[:most], rel=1e-12)
    monkeypatch.setattr(reach, "_NUMBERS", 3)
    assert [len(part) for part in responses(powers, entering, rows([3, 5]), 8)] == [3, 3, 2]
    assert [part.size for part in responses(powers, entering, rows([3, 5], [1, 0]), 3)] == [2, 2, 2]


def test_powers_end_where_they_are_small_or_grow() -> None:
    """After 2^-40 or less nothing is left; 1e100 is too large."""
    assert sum(map(len, Powers(rows([0.25])).chunks())) == 21
    assert sum(map(len, Powers(rows([4])).chunks())) == 167  # 4^166 = 8.7e99
    assert [len(chunk) for chunk in Powers(rows([0])).chunks()] == [2]
    assert next(iter(Powers(rows([0])).chunks())).ravel().tolist() == [1.0, 0.0]
