"""Factors at the wire of a loop: those of a gain and of a phase."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import flint

from proofmass.runner.derivatives.polynomial import ORDER, Terms

_WIDEST = 1.45  # half an arc, below a quarter of a turn: the tangents at its ends cross beyond it


@dataclass(frozen=True)
class Factor:
    """Factors at the wire of a loop, by one coordinate: the matrix, Arb's, with its derivative."""

    name: str
    parts: int  # 2 where they are complex
    derivatives: Callable[[Any], Sequence[Sequence[Sequence[Any]]]]
    widest: float = math.inf  # distance of two ends between which there are corners

    def terms(self, low: float, high: float, chord: bool, last: int) -> Terms:
        """Return the factors as a polynomial of the coordinate `last`, with `chord` of the one after it too.

        An arc of half a width of h is (u, v) = (cos, sin), within a triangle: u up to 1 / cos h, v
        up to sin h.
        """
        middle, half = (flint.arb(low) + high) / 2, (flint.arb(high) - low) / 2
        there = [flint.arb_mat([list(row) for row in rows]) for rows in self.derivatives(middle)]
        if high == low:
            return {(): there[0]}
        if self.parts == 1:
            return {(): there[0], (last,): there[1] * half}
        if chord:
            near, far = half.cos(), 1 / half.cos()
            wide = there[0] * ((far - near) / 2)
            return {(): there[0] * ((far + near) / 2), (last,): there[1] * half.sin(), (last + 1,): wide}
        powers = [half**order / math.factorial(order) for order in range(ORDER + 2)]
        terms = {(last,) * i: there[i % 2] * (powers[i] * (-1) ** (i // 2)) for i in range(ORDER + 1)}
        terms[()] += flint.arb_mat([[flint.arb(0, 1) * powers[-1]] * 2] * 2)
        return terms

    def corners(self, low: float, high: float, chord: bool) -> list[Sequence[Sequence[Any]]]:
        """Return the factors at both ends; with `chord` a few between which all the others lie.

        The arc of a phase lies in the triangle of its ends and the crossing of the tangents there,
        at 1 / cos of half the angle.
        """
        places = [flint.arb(low)] + [flint.arb(high)] * (high > low)
        ends = [self.derivatives(place)[0] for place in places]
        if chord and self.parts == 2 and high > low:
            middle, half = (places[1] + places[0]) / 2, (places[1] - places[0]) / 2
            ends.append([[value / half.cos() for value in row] for row in self.derivatives(middle)[0]])
        return ends


def _of_phase(p: Any) -> Sequence[Sequence[Sequence[Any]]]:
    cosine, sine = p.cos(), p.sin()
    return (
        ((cosine, -sine), (sine, cosine)),
        ((-sine, -cosine), (cosine, -sine)),
    )


GAIN = Factor("gain", 1, lambda g: (((g,),), ((flint.arb(1),),)))
PHASE = Factor("phase", 2, _of_phase, 2.0 * _WIDEST)
