"""The sine of a signal against the C library."""

import math

from proofmass.blocks import SineFunction
from tests.by_hand.responses import noise, response


def test_against_the_c_library() -> None:
    signal = [*noise(2000, 1, 3.0), 0.0, math.pi, 1000.0]
    answer = response(SineFunction(amplitude=2.5), signal)
    for u, y in zip(signal, answer, strict=True):
        assert abs(y - 2.5 * math.sin(u)) < 1e-15 * (2.0 + abs(u))
