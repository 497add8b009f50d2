"""Sine and cosine against the library's, over every angle of 12 bits and many of more; bits against plain integers."""

import math

import numpy as np
import pytest

from proofmass.blocks import FixedCordicRotation
from tests.by_hand.cordic import swept
from tests.by_hand.fixed_point import drive_fixed


def by_hand(angle: int, bits: int, iterations: int, guard: int) -> tuple[int, int]:
    """Cosine and sine in plain integers."""
    inner = bits + guard
    z, sign = angle << guard, 1
    half_turn = round(math.pi * 2**inner)
    if abs(2 * z) > half_turn:
        z, sign = z - half_turn if z > 0 else z + half_turn, -1
    x, y = sign * round(2**inner / math.prod(math.sqrt(1 + 4.0**-i) for i in range(iterations))), 0
    for i in range(iterations):
        d = 1 if z >= 0 else -1
        x, y, z = x - d * (y >> i), y + d * (x >> i), z - d * round(math.atan(2.0**-i) * 2**inner)
    return round(x / 2**guard), round(y / 2**guard)  # a quotient by a power of two is exact, and round ties to even


@pytest.mark.parametrize(
    ("bits", "iterations", "guard", "steps"), [(12, 14, 4, 1.4), (16, 18, 4, 1.4), (24, 26, 5, 1.4)]
)
def test_within_about_a_step_of_the_library(bits: int, iterations: int, guard: int, steps: float) -> None:
    """`steps` are of the last bit; all four quadrants, and on to the ends of the port at -4 and 4."""
    block = FixedCordicRotation(fraction_bits=bits, iterations=iterations, guard_bits=guard)
    angles = np.arange(-(4 << bits), 4 << bits, max(1, 2**bits // 4096))
    for name, exact in (("sine", np.sin), ("cosine", np.cos)):
        found = swept(block, name, angles)
        assert np.max(np.abs(found - exact(angles / 2**bits) * 2**bits)) < steps


@pytest.mark.parametrize(("iterations", "guard"), [(18, 4), (10, 0)])
def test_bits_against_plain_integers(iterations: int, guard: int) -> None:
    block = FixedCordicRotation(iterations=iterations, guard_bits=guard)
    turn = round(math.pi * 65536)
    angles = [
        -(4 << 16),
        (4 << 16) - 1,
        0,
        -turn,
        turn,
        turn // 2,
        turn // 2 + 1,
        -turn // 2,
        *range(-262144, 262144, 2503),
    ]
    rows = drive_fixed(block, [{"angle": angle} for angle in angles])
    assert [(row["cosine"], row["sine"]) for row in rows] == [by_hand(a, 16, iterations, guard) for a in angles]
