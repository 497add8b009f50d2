"""Closed loops as polynomials of their coordinates, against mpmath with sixty digits at random places.

Open loops are polynomials of two coordinates u and v, of second order in either. D joins the first value of a wire with
the second.
"""

import itertools
import random
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import flint
import mpmath
import numpy as np
import pytest

from proofmass.runner.derivatives.ball import BITS
from proofmass.runner.derivatives.polynomial import PolynomialBall, model_of
from proofmass.runner.derivatives.taylor_model import TaylorModel, joined
from proofmass.runner.design.proof.ball_map import BallMap, Kept
from proofmass.runner.design.proof.closed_loop import (
    bend,
    closed_terms,
    disk_terms,
    parts_of,
    shares_of,
)
from proofmass.runner.design.proof.wire_factors import GAIN, PHASE, Factor
from tests.by_hand.taylor_models import matrix_at

SIDES = ((0.125, 0.375), (-0.75, -0.25))  # of the coordinates
ORDER, VALUES = 2, 2

Numbers = Callable[..., list[list[Any]]]


def a(u: Any, v: Any) -> list[list[Any]]:
    return [[0.5 + u * v, 0.25 * u], [v * v * 3.0, 1.0 - u * u]]


def b(u: Any, v: Any) -> list[list[Any]]:
    return [[1.0 + u, 2.0 * v], [u * v * 0.5 + 0.125, 3.0 + v * v]]


def c(u: Any, v: Any) -> list[list[Any]]:
    return [[v - 1.0, u * u * 0.5 + 0.0 * v], [u * v + 2.0, 1.5 * u]]


def d(u: Any, v: Any) -> list[list[Any]]:
    return [[0.0, 0.0], [0.75 + u + v * u, 0.0]]


@pytest.fixture(autouse=True)
def bits() -> Iterator[None]:
    with flint.ctx.workprec(BITS):
        yield


def whole_map() -> BallMap:
    u, v = (PolynomialBall.coordinate(*side, i) for i, side in enumerate(SIDES))
    above = [[*left, *right] for left, right in zip(a(u, v), b(u, v), strict=True)]
    below = [[*left, *right] for left, right in zip(c(u, v), d(u, v), strict=True)]
    return BallMap(ORDER, [*above, *below], Kept((0, 1), (0, 1), (0, 1)))


def places(sides: Sequence[tuple[float, float]]) -> Iterator[tuple[list[Any], list[Any]]]:
    """Parts of half sides from their middles, in whole eighths, and the numbers there."""
    draw = random.Random(5)
    for _ in range(6):
        parts = [draw.randint(-8, 8) / 8 for _ in sides]
        yield (
            parts,
            [(low + high) / 2 + part * (high - low) / 2 for part, (low, high) in zip(parts, sides, strict=True)],
        )


def assert_holds(
    found: TaylorModel, exact: Callable[..., Any], *sides: tuple[float, float], room: float = 1e-12
) -> None:
    """A polynomial holds the exact matrix at random places, and is off by its room at most."""
    for parts, numbers in places((*SIDES, *sides)):
        with mpmath.workdps(60):
            matrix = mpmath.matrix(exact(*map(mpmath.mpf, numbers)))
        for i, row in enumerate(matrix_at(found, parts)):
            for j, value in enumerate(row):
                assert value.overlaps(flint.arb(mpmath.nstr(matrix[i, j], 50)))
                assert value.rad() < room


def test_an_open_loop_in_its_parts() -> None:
    for part, of in zip(parts_of(whole_map()), (a, b, c, d), strict=True):
        assert_holds(part, of)


def test_matrices_of_matrices() -> None:
    first, second, third, fourth = parts_of(whole_map())
    whole = joined([[first, second], [third, fourth]])
    assert_holds(whole, lambda u, v: _joined(a(u, v), b(u, v), c(u, v), d(u, v)))


def test_where_a_loop_bends() -> None:
    """In halves of 1/8 and 1/4: 1 u u, a half of it and none elsewhere; 3 v v and 1 v v."""
    assert [bend(whole_map(), place) for place in (0, 1, 2)] == pytest.approx([1.5 / 64, 4.0 / 16, 0.0])


def _joined(a: Any, b: Any, c: Any, d: Any) -> list[list[Any]]:
    above = [[*left, *right] for left, right in zip(_rows(a), _rows(b), strict=True)]
    return above + [[*left, *right] for left, right in zip(_rows(c), _rows(d), strict=True)]


def _rows(matrix: Any) -> list[list[Any]]:
    return matrix.tolist() if isinstance(matrix, mpmath.matrix) else matrix


def _kronecker(left: list[list[Any]], right: list[list[Any]]) -> Any:
    return mpmath.matrix([[x * y for x in row for y in other] for row in left for other in right])


@pytest.mark.parametrize(("factor", "ends", "room"), [(GAIN, (1.5, 2.0), 2.0), (PHASE, (0.5, 0.75), 1.0)])
def test_a_loop_that_is_closed_with_a_factor(factor: Factor, ends: tuple[float, float], room: float) -> None:
    """A + B F (I - D F)^-1 C, the factor's coordinate the last."""

    def closed(u: Any, v: Any, w: Any) -> Any:
        turn = [[w]] if factor is GAIN else [[mpmath.cos(w), -mpmath.sin(w)], [mpmath.sin(w), mpmath.cos(w)]]
        once = [[mpmath.mpf(int(i == j)) for j in range(len(turn))] for i in range(len(turn))]
        wide = [_kronecker(once, rows(u, v)) for rows in (a, b, c, d)]
        f = _kronecker(turn, [[1, 0], [0, 1]])
        return wide[0] + wide[1] * f * (mpmath.eye(f.rows) - wide[3] * f) ** -1 * wide[2]

    found = closed_terms(parts_of(whole_map()), VALUES, factor.model(*ends, False, 2), factor.parts)
    assert_holds(found, closed, ends, room=room)


def test_a_loop_with_a_disk_of_factors() -> None:
    """[A + B E C, B E; s E C, s (E - I / 2)] with E = (I - D)^-1."""
    size = 0.375

    def closed(u: Any, v: Any) -> Any:
        whole, into, out, direct = (mpmath.matrix(rows(u, v)) for rows in (a, b, c, d))
        e = (mpmath.eye(VALUES) - direct) ** -1
        return _joined(whole + into * e * out, into * e, size * e * out, size * (e - 0.5 * mpmath.eye(VALUES)))

    assert_holds(disk_terms(parts_of(whole_map()), size), closed, room=0.1)


# -- between corners ---------------------------------------------------------------------------------------------------


def bent(u: Any, v: Any) -> list[list[Any]]:
    return [[u * v + 2.0 * u * u, v**3], [1.0 / (3.0 + u), u * v * v * 0.5]]


@pytest.mark.parametrize("chosen", [(0, 1), (1,), ()])
def test_a_matrix_lies_between_its_corners_and_what_its_terms_add(chosen: tuple[int, ...]) -> None:
    """Coordinates that are at no end stay in the middle."""
    u, v = (PolynomialBall.coordinate(*side, i) for i, side in enumerate(SIDES))
    model = model_of(bent(u, v))
    corners, _ = model.at_corners(chosen)
    ends = itertools.product(*(side if i in chosen else (sum(side) / 2,) for i, side in enumerate(SIDES)))
    assert corners == pytest.approx(np.array([bent(*end) for end in ends]), rel=1e-6)
    shares = sum(shares_of(model, {*chosen}, 2).values(), np.zeros((2, 2)))
    assert (shares < [[0.5, 0.5], [0.1, 0.15]]).all()
    for parts, numbers in places(SIDES):
        weights = [
            np.prod(one) for one in itertools.product(*(((1 - parts[i]) / 2, (1 + parts[i]) / 2) for i in chosen))
        ]
        mixed = np.tensordot(np.array(weights), corners, 1)
        assert (np.abs(np.array(bent(*numbers)) - mixed) <= shares + 1e-15).all()
