"""Which side of a box is halved, and norms of noise of one state, worked out by hand."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from proofmass.runner.design.proof.closed_loop import Family, OpenCorners
from proofmass.runner.design.proof.contraction import Norm
from proofmass.runner.design.proof.enclosed import Enclosed
from proofmass.runner.design.proof.look import BoxLook, _halves, _norm, _weights, halved, widths
from proofmass.runner.design.proof.noise_norm import norm_of_noise, rms_at_corners, with_noise
from proofmass.runner.design.proof.rest_norm import Start

WHOLE = ((0.0, 8.0), (0.0, 4.0), (1.0, 1.0))
BOX = ((0.0, 2.0), (1.0, 4.0), (1.0, 1.0))


def test_sides_are_halved_in_their_middle() -> None:
    assert widths(BOX, WHOLE) == [0.25, 0.75, 0.0]
    assert halved(BOX, 0) == [((0.0, 1.0), *BOX[1:]), ((1.0, 2.0), *BOX[1:])]
    assert halved(BOX, 1) == [(BOX[0], (1.0, 2.5), BOX[2]), (BOX[0], (2.5, 4.0), BOX[2])]


@pytest.mark.parametrize(
    ("weights", "sides", "place"),
    [
        ([3.0, 2.0, 9.0], range(3), 0),  # the last has no width
        ([1.0, 2.0, 9.0], range(3), 1),
        ([3.0, 2.0, 9.0], range(1, 3), 1),
        ([0.0, 0.0, 9.0], range(3), 1),  # without weights the widest
        ([0.0, 0.0, 9.0], range(1), 0),
    ],
)
def test_the_side_of_the_largest_weight_is_halved(weights: list[float], sides: range, place: int) -> None:
    assert _halves(BOX, weights, WHOLE, sides) == halved(BOX, place)


def test_a_box_that_is_too_fine_is_not_halved() -> None:
    assert _halves(BOX, [1.0, 1.0, 1.0], WHOLE, range(2, 3)) == []
    point = ((2.0, 2.0), (1.0, 1.0), (1.0, 1.0))
    assert _halves(point, [1.0, 1.0, 1.0], WHOLE, range(3)) == []


def promised(box: Any, shares: dict[int, float], moves: list[float], worst: float, noise: Any = None) -> list[float]:
    family = SimpleNamespace(noise=noise, centre=np.array([[0.6]]))
    of: Any = SimpleNamespace(shares=shares, moves=lambda: moves, worst=lambda: worst, family=family)
    return _weights(of, box)


def test_what_halving_a_side_promises() -> None:
    """Where corners contract, what lies beyond them; else how far a side moves the matrix, or what it adds."""
    wide = ((0.0, 1.0), (2.0, 2.0), (0.0, 1.0), (0.5, 2.0))
    shares = {0: 0.25, 1: 0.5, 3: 0.125}
    assert promised(wide, shares, [7.0, 8.0, 9.0], 0.99) == [0.25, 0.5, 0.0, 0.125]
    assert promised(wide, shares, [7.0, 8.0, 9.0], 1.0) == [7.0, 0.5, 8.0, 9.0]
    assert promised(wide, {0: 0.0}, [7.0, 8.0, 9.0], 0.99) == [7.0, 0.0, 8.0, 9.0]
    fixed = (*wide[:3], (1.0, 1.0))
    assert promised(fixed, shares, [7.0, 8.0], 1.0) == [7.0, 0.5, 8.0, 0.125]
    # twice what is beyond the corners, and squares of moves over 1 - 0.36
    noisy = promised(fixed, shares, [0.8, 1.6], 0.5, noise=0)
    assert noisy == pytest.approx([0.5 + 1.0, 1.0, 4.0, 0.25])


def test_a_norm_of_the_whole_serves_or_is_improved() -> None:
    given = Enclosed(np.array([[[0.5, 8.0], [0.0, 0.5]]]), np.zeros((1, 2, 2)))
    family, good = Family(given, 1, {}), np.diag([32.0, 1.0])
    served = _norm(family, Start(good))
    assert served is not None
    assert served.transform is good
    bad = _norm(family, Start(np.eye(2)))
    assert bad is not None
    assert bad.contracts()
    alone = _norm(family, Start(np.eye(2), alone=True))
    assert alone is not None
    assert alone.worst() == Norm(np.eye(2), family).worst()
    growing = Family(Enclosed(np.array([[[1.5]]]), np.zeros((1, 1, 1))), 1, {})
    assert _norm(growing, Start(np.eye(1))) is None
    assert _norm(growing, None) is None


def opened(*corners: tuple[float, float, float, float]) -> OpenCorners:
    """x' = a x + b w, y = c x + d w."""
    middle = np.array([[[a, b], [c, d]] for a, b, c, d in corners])
    return OpenCorners(1, 1, Enclosed(middle, np.zeros_like(middle)), None, None, (), 0)


RMS = math.sqrt(4.0 * 9.0 / 0.75 + 0.25)  # of a = 0.5, b = 2, c = 3 and d = 0.5


def test_the_rms_of_one_state() -> None:
    """b^2 c^2 / (1 - a^2) + d^2; nothing bounds what grows."""
    found = rms_at_corners(opened((0.5, 2.0, 3.0, 0.5), (1.0, 2.0, 3.0, 0.5), (0.0, 2.0, 3.0, 0.0)))
    assert found == pytest.approx([RMS, math.inf, 6.0])


@pytest.mark.parametrize(("part", "holds"), [(1.001, True), (0.999, False)])
def test_a_norm_that_shows_a_bound_of_the_noise(part: float, holds: bool) -> None:
    found = norm_of_noise(opened((0.5, 2.0, 3.0, 0.5)), RMS * part, None)
    assert found is not None
    assert found.contracts() is holds
    if holds:
        again = norm_of_noise(opened((0.5, 2.0, 3.0, 0.5)), RMS * part, Start(found.transform))
        assert again is not None
        assert again.transform is found.transform
    assert norm_of_noise(opened((1.5, 2.0, 3.0, 0.5)), 1e9, None) is None


def test_a_family_with_noise() -> None:
    found = with_noise(opened((0.5, 2.0, 3.0, 0.25)), 7.0)
    assert found.corners.middle.tolist() == [[[0.5, 0.0], [3.0, 0.0]]]
    assert found.noise is not None
    assert found.noise.middle.tolist() == [[[2.0], [0.25]]]
    assert (found.still, found.limit, found.factors) == (1, 7.0, 1)
    assert found.beyond_noise is not None
    assert found.beyond_noise.tolist() == [[0.0], [0.0]]


@pytest.mark.parametrize(
    ("in_one_norm", "worst", "noise", "whole", "sides"),
    [
        (False, None, None, True, [0, 1, 2]),
        (True, 0.9, None, True, [0, 1, 2]),  # the norm serves the corners: parameters, and the factor of the whole
        (True, 0.9, None, False, [0, 1]),
        (True, 1.0, None, True, [2]),
        (True, 1.0, None, False, []),
        (True, 0.9, "noise", True, [2]),
        (True, None, None, True, [2]),
    ],
)
def test_sides_that_may_be_halved(in_one_norm: bool, worst: Any, noise: Any, whole: bool, sides: list[int]) -> None:
    look: Any = SimpleNamespace(claim=SimpleNamespace(in_one_norm=in_one_norm), whole=WHOLE)
    norm: Any = SimpleNamespace(family=SimpleNamespace(noise=noise), worst=lambda: worst)
    box = (*WHOLE[:2], (0.5, 1.0)) if whole else BOX
    assert [*BoxLook._sides(look, None if worst is None else norm, box)] == sides
