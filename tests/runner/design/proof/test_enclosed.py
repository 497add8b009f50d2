"""Matrices with a radius hold what exact fractions give, and hardly more."""

from fractions import Fraction

import numpy as np
import pytest

from proofmass.runner.design.proof.enclosed import Enclosed

DICE = np.random.default_rng(4)
ONE, TWO = (Enclosed(DICE.normal(size=(1, 3, 3)), 1e-12 * DICE.random((1, 3, 3))) for _ in range(2))
CENTRE = DICE.normal(size=(3, 3))


def exact(of: Enclosed, signs: int) -> list[list[Fraction]]:
    """A matrix at the ends of its entries."""
    ends = np.sign(np.random.default_rng(signs).normal(size=(3, 3))).astype(int)
    return [
        [Fraction(m) + int(sign) * Fraction(r) for m, r, sign in zip(*rows, strict=True)]
        for rows in zip(of.middle[0].tolist(), of.radius[0].tolist(), ends, strict=True)
    ]


@pytest.mark.parametrize("signs", range(4))
def test_operations_hold_all_that_their_operands_hold(signs: int) -> None:
    a, b, centre = exact(ONE, signs), exact(TWO, signs + 10), [[Fraction(v) for v in row] for row in CENTRE.tolist()]
    numbers = range(3)
    product = [[sum((a[i][k] * b[k][j] for k in numbers), Fraction(0)) for j in numbers] for i in numbers]
    for found, expected in (
        (ONE @ TWO, product),
        (ONE + TWO, [[a[i][j] + b[i][j] for j in numbers] for i in numbers]),
        (ONE.moved(CENTRE), [[a[i][j] + centre[i][j] for j in numbers] for i in numbers]),
        (ONE.scaled(-0.1), [[a[i][j] / -10 for j in numbers] for i in numbers]),
        (ONE.scaled(30.0), [[a[i][j] * 30 for j in numbers] for i in numbers]),
    ):
        for i in numbers:
            for j in numbers:
                off = abs(expected[i][j] - Fraction(float(found.middle[0, i, j])))
                assert off <= Fraction(float(found.radius[0, i, j]))
    assert float((ONE @ TWO).radius.max()) < 20e-12
    assert float(ONE.scaled(-0.1).radius.max()) < 0.11e-12
    assert float(ONE.scaled(30.0).radius.max()) < 31e-12
