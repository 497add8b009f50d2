"""Products of numbers without error, against fractions."""

import random
from fractions import Fraction

from proofmass.blocks.arithmetic.pairs import exact_product


def test_a_product_and_what_rounding_took_off_it_are_exact() -> None:
    dice = random.Random(1)
    for _ in range(1000):
        a, b = (float(dice.getrandbits(53)) * 2.0 ** dice.randint(-100, 100) for _ in range(2))
        assert sum(map(Fraction, exact_product(a, -b))) == -Fraction(a) * Fraction(b)
