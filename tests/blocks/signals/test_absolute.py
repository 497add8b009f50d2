"""The absolute value, at zero and far from it."""

import math

from proofmass.blocks import Absolute
from tests.by_hand.responses import noise, response


def test_it_is_the_distance_from_zero() -> None:
    signal = [*noise(200), 0.0, 5e-324, -5e-324, 1e308, -1e308]
    assert response(Absolute(), signal) == [math.sqrt(u * u) if 1e-9 < abs(u) < 1e9 else max(u, -u) for u in signal]


def test_zero_has_no_sign() -> None:
    assert math.copysign(1.0, response(Absolute(), [-0.0])[0]) == 1.0
