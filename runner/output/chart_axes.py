"""Axes of charts: round ticks, and the texts of their numbers."""

import math
from collections.abc import Sequence
from typing import NamedTuple

_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
_LARGEST, _SMALLEST = 6, -4  # powers of ten that are written out


class Axis(NamedTuple):
    """Ends of an axis, its ticks, their texts, and the power of ten that all of them leave out."""

    low: float
    high: float
    ticks: tuple[float, ...]
    texts: tuple[str, ...]
    power: int

    def place(self, value: float) -> float:
        """Return where a value stands, from 0 to 1."""
        return (value - self.low) / (self.high - self.low)

    def note(self) -> str:
        """Return the power of ten as a text for the label of the axis."""
        return f" × 10{str(self.power).translate(_RAISED)}" if self.power else ""


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def axis(values: Sequence[float], ticks: int = 5, rim: float = 0.04, counts: bool = False) -> Axis:
    """Return an axis that shows finite values, with a rim of its length at both ends; ticks of counts are whole.

    >>> axis([0.0, 10.0], rim=0.0).texts, axis([9.80661, 9.80669], rim=0.0).texts[0]
    (('0', '2', '4', '6', '8', '10'), '9.80662')
    >>> axis([0.0, 3.0], rim=0.0, counts=True).texts
    ('0', '1', '2', '3')
    """
    finite = [value for value in values if math.isfinite(value)]
    low, high = (min(finite), max(finite)) if finite else (0.0, 1.0)
    if high - low <= 1e-12 * max(abs(low), abs(high), 1e-300):
        half = 0.5 * abs(low) or 0.5
        low, high = low - half, high + half
    edge = rim * (high - low)
    low, high = low - edge, high + edge
    rough = (high - low) / ticks
    power = math.floor(math.log10(rough))
    steps = [step for step in (s * 10.0**power for s in _STEPS) if not counts or step.is_integer()] or [1.0]
    step = min(steps, key=lambda step: abs(math.log(step / rough)))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    at = tuple(number * step for number in range(first, last + 1))
    size = math.floor(math.log10(max(abs(low), abs(high))))
    left_out = size if size >= _LARGEST or size < _SMALLEST else 0
    digits = max(0, left_out - math.floor(math.log10(step) + 1e-9) + (round(step / 10.0**power, 6) == 2.5))
    texts = tuple(f"{value / 10.0**left_out + 0.0:.{digits}f}".replace("-", "\N{MINUS SIGN}") for value in at)
    return Axis(low, high, at, texts, left_out)
