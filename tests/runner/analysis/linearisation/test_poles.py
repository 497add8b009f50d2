"""Vectors of poles: of matrices in parts that act on each other one way, against their definition."""

from fractions import Fraction

import numpy as np
import pytest

from proofmass.runner.analysis.linearisation.poles import (
    Pole,
    Variation,
    _vectors,
    characteristic,
    inexact,
    judged,
    parts_of,
    roots,
)
from proofmass.runner.analysis.linearisation.rational import transfer
from proofmass.runner.host.arrays import Array


def in_parts(seed: int) -> np.ndarray:  # type: ignore[type-arg]
    """Three parts of two states each, of which later ones read earlier ones, in a random order of the states."""
    dice = np.random.default_rng(seed)
    a = np.kron(np.tril(np.ones((3, 3))), np.ones((2, 2))) * dice.uniform(0.2, 1.0, (6, 6))
    order = dice.permutation(6)
    return a[np.ix_(order, order)]


@pytest.mark.parametrize("seed", range(4))
def test_vectors_of_every_pole(seed: int) -> None:
    a = in_parts(seed)
    assert [len(part) for part in parts_of(a)] == [2, 2, 2]
    found = [root for part in parts_of(a) for root in roots(characteristic(a[np.ix_(part, part)]))]
    assert sorted(complex(root).real for root in found) == pytest.approx(np.sort(np.linalg.eigvals(a).real), rel=1e-9)
    for root in found:
        right, left = _vectors(a, root)
        assert abs(a @ right - complex(root) * right).max() < 1e-12 * abs(right).max()
        assert abs(left @ a - complex(root) * left).max() < 1e-12 * abs(left).max()
        assert max(abs(right)) == pytest.approx(1.0)


def test_a_quotient_is_exact_where_units_of_states_would_lose_digits() -> None:
    """b / (z - 1 / 2 - 1 / (z - 1 / 4)) at z = 2, of the least number b that is not a power of two."""
    least = 3 * 5e-324
    a = np.array([[0.5, 2.0**60], [2.0**-60, 0.25]])
    found = transfer(a, np.array([least, 0.0]), np.array([1.0, 0.0]), 0.0)
    assert found is not None
    expected = Fraction(least) / (Fraction(3, 2) - 1 / Fraction(7, 4))
    assert Fraction(int(found.numerator(2)), int(found.denominator(2))) == expected


def test_numbers_of_twelve_bits_are_exact() -> None:
    """Of any size and sign; what has more bits is the result of arithmetic."""
    exact, more = 1.0 + 2.0**-11, 1.0 + 2.0**-12
    matrix = np.array([[0.0, 1.0, -0.5, exact], [1e-3, 1.0 / 3.0, more, -more * 2.0**-40]])
    assert inexact(matrix).tolist() == [[0.0] * 4, [1.0] * 4]
    assert inexact(np.array([[exact * 2.0**60, more * 2.0**60]])).tolist() == [[0.0, 1.0]]


def test_a_change_moves_poles_alike_in_any_units_of_the_states() -> None:
    matrix, change = np.array([[0.6, 0.3], [0.4 * 0.999, 0.7]]), 1e-9 * np.array([[1.0, 3.0], [2.0, 1.0]])
    units = np.array([1.0, 2.0**40])
    in_units = (each / units[:, None] * units for each in (matrix, change))
    moved = [pole.uncertainty for pole in _moved(matrix, change)]
    assert 1e-7 < moved[0] < 1e-3
    assert [pole.uncertainty for pole in _moved(*in_units)] == pytest.approx(moved, rel=1e-9)


def _moved(matrix: Array, change: Array) -> tuple[Pole, ...]:
    poles = np.linalg.eigvals(matrix).astype(complex)
    return judged(matrix, True, Variation(change, poles, np.zeros(len(poles))))[1]
