"""The root squared is the input again."""

import pytest

from proofmass.blocks import SquareRoot
from tests.by_hand.responses import noise, response


def test_its_square_is_the_input() -> None:
    signal = [abs(u) for u in noise(500)]
    assert [y * y for y in response(SquareRoot(), signal)] == pytest.approx(signal, rel=1e-15)


def test_below_zero_it_is_zero_or_has_the_sign_of_the_input() -> None:
    assert response(SquareRoot(), [-4.0, 0.0, 4.0]) == [0.0, 0.0, 2.0]
    assert response(SquareRoot(signed=True), [-4.0, 0.0, 6.25]) == [-2.0, 0.0, 2.5]
