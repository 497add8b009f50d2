"""Derivatives of closed loops by their coordinates, against differences of mpmath with sixty digits.

Open loops are polynomials of two coordinates u and v, of second order in either. D joins the first value of a wire with
the second.
"""

from collections.abc import Callable
from itertools import combinations_with_replacement
from typing import Any

import flint
import mpmath
import numpy as np
import pytest

from proofmass.runner.derivatives.dual import Dual
from proofmass.runner.design.proof import closed_loop
from proofmass.runner.design.proof.ball_ticks import FIRST, SECOND
from proofmass.runner.design.proof.closed_loop import Jet
from proofmass.runner.design.proof.wire_factors import GAIN, PHASE, Factor

MIDDLE = (0.25, -0.5)  # of the coordinates
ORDER, VALUES = 2, 2
_NEAR = mpmath.mpf(10) ** -15

Numbers = Callable[..., list[list[Any]]]


def a(u: Any, v: Any) -> list[list[Any]]:
    return [[0.5 + u * v, 0.25 * u], [v * v * 3.0, 1.0 - u * u]]


def b(u: Any, v: Any) -> list[list[Any]]:
    return [[1.0 + u, 2.0 * v], [u * v * 0.5 + 0.125, 3.0 + v * v]]


def c(u: Any, v: Any) -> list[list[Any]]:
    return [[v - 1.0, u * u * 0.5 + 0.0 * v], [u * v + 2.0, 1.5 * u]]


def d(u: Any, v: Any) -> list[list[Any]]:
    return [[0.0, 0.0], [0.75 + u + v * u, 0.0]]


def jet(of: Numbers) -> Jet:
    u, v = (Dual(Dual(x, {i: 1.0}, SECOND), {i: 1.0}, FIRST) for i, x in enumerate(MIDDLE))
    return closed_loop._jet(of(u, v))


def differences(of: Callable[..., Any], at: tuple[float, ...]) -> dict[tuple[int, ...], Any]:
    """The matrix there, and its derivatives up to the second that are not zero."""
    with mpmath.workdps(60):
        count, places = len(at), [mpmath.mpf(x) for x in at]

        def shifted(*by: tuple[int, int]) -> Any:
            moved = list(places)
            for i, sign in by:
                moved[i] = moved[i] + sign * _NEAR
            return mpmath.matrix(of(*moved))

        found = {(): shifted()}
        for i in range(count):
            found[i,] = (shifted((i, 1)) - shifted((i, -1))) / (2 * _NEAR)
        for i, j in combinations_with_replacement(range(count), 2):
            corners = [shifted((i, s), (j, t)) * (s * t) for s in (1, -1) for t in (1, -1)]
            found[i, j] = (corners[0] + corners[1] + corners[2] + corners[3]) / (4 * _NEAR**2)
        return {key: m for key, m in found.items() if mpmath.norm(m, 1) > mpmath.mpf(10) ** -25}


def assert_same(found: Jet, expected: dict[tuple[int, ...], Any]) -> None:
    some = {key: m for key, m in found.items() if not all(value.is_zero() for value in m.entries())}
    assert some.keys() == expected.keys()
    for key, matrix in some.items():
        rows = np.array([[float(value) for value in row] for row in matrix.tolist()])
        assert rows == pytest.approx(np.array(expected[key].tolist(), dtype=float), rel=1e-12, abs=1e-12), key


@pytest.mark.parametrize("of", [a, b, c, d])
def test_an_open_loop_with_its_derivatives(of: Numbers) -> None:
    assert_same(jet(of), differences(of, MIDDLE))


def test_products_and_matrices_of_matrices() -> None:
    assert_same(
        closed_loop.product(jet(a), closed_loop.product(jet(b), jet(c))),
        differences(lambda u, v: mpmath.matrix(a(u, v)) * mpmath.matrix(b(u, v)) * mpmath.matrix(c(u, v)), MIDDLE),
    )
    assert_same(
        closed_loop.joined([[jet(a), jet(b)], [jet(c), jet(d)]], (ORDER, VALUES)),
        differences(lambda u, v: _joined(a(u, v), b(u, v), c(u, v), d(u, v)), MIDDLE),
    )


def _joined(a: Any, b: Any, c: Any, d: Any) -> list[list[Any]]:
    above = [[*left, *right] for left, right in zip(_rows(a), _rows(b), strict=True)]
    return above + [[*left, *right] for left, right in zip(_rows(c), _rows(d), strict=True)]


def _rows(matrix: Any) -> list[list[Any]]:
    return matrix.tolist() if isinstance(matrix, mpmath.matrix) else matrix


def _kronecker(left: list[list[Any]], right: list[list[Any]]) -> Any:
    return mpmath.matrix([[x * y for x in row for y in other] for row in left for other in right])


@pytest.mark.parametrize(("factor", "place"), [(GAIN, 1.75), (PHASE, 0.5)])
def test_a_loop_that_is_closed_with_a_factor(factor: Factor, place: float) -> None:
    """A + B F (I - D F)^-1 C, the factor's coordinate the last."""

    def closed(u: Any, v: Any, w: Any) -> Any:
        turn = [[w]] if factor is GAIN else [[mpmath.cos(w), -mpmath.sin(w)], [mpmath.sin(w), mpmath.cos(w)]]
        once = [[mpmath.mpf(int(i == j)) for j in range(len(turn))] for i in range(len(turn))]
        wide = [_kronecker(once, rows(u, v)) for rows in (a, b, c, d)]
        f = _kronecker(turn, [[1, 0], [0, 1]])
        return wide[0] + wide[1] * f * (mpmath.eye(f.rows) - wide[3] * f) ** -1 * wide[2]

    found = closed_loop._closed_jet((jet(a), jet(b), jet(c), jet(d)), VALUES, factor, flint.arb(place), 2)
    assert_same(found, differences(closed, (*MIDDLE, place)))


def test_a_loop_with_a_disk_of_factors() -> None:
    """[A + B E C, B E; s E C, s (E - I / 2)] with E = (I - D)^-1."""
    size = 0.375

    def closed(u: Any, v: Any) -> Any:
        whole, into, out, direct = (mpmath.matrix(rows(u, v)) for rows in (a, b, c, d))
        e = (mpmath.eye(VALUES) - direct) ** -1
        return _joined(whole + into * e * out, into * e, size * e * out, size * (e - 0.5 * mpmath.eye(VALUES)))

    found = closed_loop._disk_jet((jet(a), jet(b), jet(c), jet(d)), ORDER, VALUES, flint.arb(size))
    assert_same(found, differences(closed, MIDDLE))
