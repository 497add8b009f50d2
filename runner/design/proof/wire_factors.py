"""Factors at the wire of a loop: those of a gain and of a phase."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import methodcaller
from typing import Any

import flint

from proofmass.runner.derivatives.ball import Ball
from proofmass.runner.derivatives.polynomial import PolynomialBall, model_of
from proofmass.runner.derivatives.taylor_model import TaylorModel

_WIDEST = 1.45  # half an arc, below a quarter of a turn: the tangents at its ends cross beyond it
_COSINE, _SINE = methodcaller("cos"), methodcaller("sin")


@dataclass(frozen=True)
class Factor:
    """Factors at the wire of a loop, by one coordinate."""

    name: str
    parts: int  # 2 where they are complex
    widest: float = math.inf  # distance of two ends between which there are corners

    def model(self, low: float, high: float, chord: bool, last: int) -> TaylorModel:
        """Return the factors as a polynomial of the coordinate `last`, with `chord` of the one after it too.

        An arc of half a width of h is (u, v) = (cos, sin), within a triangle: u up to 1 / cos h, v
        up to sin h.
        """
        place = PolynomialBall.coordinate(low, high, last)
        if not (chord and self.parts == 2 and low < high):
            return model_of(self._matrix(place))
        middle, half = (flint.arb(low) + high) / 2, (flint.arb(high) - low) / 2
        near, far = half.cos(), 1 / half.cos()
        along = Ball((far + near) / 2) + Ball((far - near) / 2) * PolynomialBall.about(0.0, 1.0, last + 1)
        across = Ball(half.sin()) * PolynomialBall.about(0.0, 1.0, last)
        cosine, sine = Ball(middle.cos()), Ball(middle.sin())
        return model_of(_turned(cosine * along - sine * across, sine * along + cosine * across))

    def corners(self, low: float, high: float, chord: bool) -> list[Sequence[Sequence[Any]]]:
        """Return the factors at both ends; with `chord` a few between which all the others lie.

        The arc of a phase lies in the triangle of its ends and the crossing of the tangents there,
        at 1 / cos of half the angle.
        """
        ends = [self._matrix(Ball(flint.arb(place))) for place in ([low, high] if low < high else [low])]
        if chord and self.parts == 2 and high > low:
            middle, half = (flint.arb(low) + high) / 2, (flint.arb(high) - low) / 2
            ends.append(_turned(Ball(middle.cos() / half.cos()), Ball(middle.sin() / half.cos())))
        return ends

    def _matrix(self, place: Any) -> Sequence[Sequence[Any]]:
        """Return the factor at a place of its coordinate, a ball or a polynomial."""
        return ((place,),) if self.parts == 1 else _turned(_of(place, _COSINE), _of(place, _SINE))


def _of(place: Any, function: Callable[[Any], Any]) -> Any:
    return place.through(function) if isinstance(place, PolynomialBall) else Ball(function(place.arb))


def _turned(cosine: Any, sine: Any) -> Sequence[Sequence[Any]]:
    return (cosine, -sine), (sine, cosine)


GAIN = Factor("gain", 1)
PHASE = Factor("phase", 2, 2.0 * _WIDEST)
