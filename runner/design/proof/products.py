"""Parameters that act on a loop as one product: amplifiers in a row, a reference that divides what another multiplies.

    A(s) = S A S^-1,  B(s) = S B U^-1,  C(s) = s^p U C S^-1,  D(s) = s^p U D U^-1   with S and U diagonal, powers of s

If this is all that a parameter does when it is s times as large, poles are those of the loop with s^p at its wire,
whatever the other parameters are. Several such parameters act as their product, with p as powers. This is proved by
calling the functions of the blocks with a number that carries its degree (`homogeneous`).
"""

from fractions import Fraction
from typing import Any

import flint

from proofmass.runner.derivatives.ball import UndecidedError, ball, enclosing
from proofmass.runner.derivatives.homogeneous import Homogeneous, loop_degree
from proofmass.runner.design.proof.ball_map import Starting
from proofmass.runner.design.proof.coordinates import Coordinates, ProductRange
from proofmass.runner.design.worst.ranges import Range


def with_products(loop: Starting, coordinates: Coordinates) -> Coordinates:
    """Return coordinates in which parameters that act on a loop at the start of a run as one product are one."""
    with enclosing():
        degrees = {place: degree_in(loop, coordinates, r, place) for place, r in enumerate(coordinates.ranges)}
        acting = {place: degree for place, degree in degrees.items() if degree}
        for first in sorted(acting, key=lambda place: acting[place] < 0):
            ordered = [first, *(place for place in acting if place != first)]
            powers = [float(acting[place] / acting[first]) for place in ordered]
            product = ProductRange.of([coordinates.ranges[place] for place in ordered], powers)  # which goes further
            if len(ordered) > 1 and degree_in(loop, coordinates, product, first) == acting[first]:
                return coordinates.merged(product, ordered)
    return coordinates


def degree_in(loop: Starting, coordinates: Coordinates, wanted: Range, place: int) -> Fraction | None:
    """Return the degree of a loop in a parameter within a range; None if it has none there, or is not known."""
    low, nominal, high = wanted.low, wanted.nominal, wanted.high
    if not (low <= nominal <= high and low < high and low * high > 0.0):
        return None
    values: list[Any] = [ball(r.low, r.high) for r in coordinates.ranges]
    values[place] = Homogeneous(flint.arb(nominal), 1, ball(low, high).arb / nominal)
    try:
        whole = loop.map(coordinates.parameters(values))
    except UndecidedError:
        return None
    return loop_degree(whole.rows, whole.order)
