"""Taylor models read at a place of their coordinates: with Arb, term by term."""

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import flint
import numpy as np

from proofmass.runner.derivatives.polynomial import PolynomialBall
from proofmass.runner.derivatives.taylor_model import TaylorModel


def number_at(number: Any, parts: Sequence[Any]) -> Any:
    """All that a number may be at a place, each coordinate from -1 to 1."""
    if not isinstance(number, PolynomialBall):
        return number.arb
    matrix = number.model.placed(lambda values: np.asarray(values)[..., None, None])
    return matrix_at(matrix, parts)[0][0]


def matrix_at(model: TaylorModel, parts: Sequence[Any]) -> list[list[Any]]:
    """All that the entries of a matrix may be at a place."""
    places = [flint.arb(part.numerator) / part.denominator for part in map(Fraction, parts)]
    found = [[flint.arb(0, radius) for radius in row] for row in np.asarray(model.radius).tolist()]
    for powers, term in zip(model.of.exponents.tolist(), model.coefficients.tolist(), strict=True):
        moved = math.prod((x**power for x, power in zip(places, powers, strict=False)), start=flint.arb(1))
        found = [
            [total + moved * value for total, value in zip(*rows, strict=True)]
            for rows in zip(found, term, strict=True)
        ]
    return found
