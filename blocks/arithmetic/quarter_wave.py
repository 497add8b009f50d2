"""A sine from a table of a quarter of it: sin(2 pi (u + 1/2) / 2^P) for the phase word u, to the nearest step.

Half a step beside the phase the four quarters are the same table, read up or down, with either sign
(Nicholas and Samueli, Proc. 41st Annual Frequency Control Symposium, 1987).
"""

import math
from typing import Any

from proofmass.blocks.arithmetic.elementary import sine_of_turns
from proofmass.blocks.arithmetic.fixed_point import where
from proofmass.blocks.arithmetic.mantissa import WholeNumber


def quarter_wave(phase_bits: int, fraction: int) -> tuple[int, ...]:
    """Mantissas of the first quarter.

    >>> quarter_wave(4, 8)
    (50, 142, 213, 251)
    """
    steps = range(1 << (phase_bits - 2))
    return tuple(round(math.ldexp(sine_of_turns((i + 0.5) / (1 << phase_bits)), fraction)) for i in steps)


def sine_word(table: tuple[int, ...], phase: WholeNumber) -> Any:
    """Mantissa of the sine at a phase word; bits above the first `phase_bits` are whole turns."""
    size = len(table)
    quadrant = phase & size
    place = where(quadrant > 0, -1 - phase, phase) & (size - 1)
    value = _entry(table, place)
    return where((phase & (2 * size)) > 0, -value, value)


def _entry(table: tuple[int, ...], place: WholeNumber) -> Any:
    """The entry at a place, chosen bit by bit from the lowest."""
    entries: list[Any] = list(table)
    bit = 1
    while len(entries) > 1:
        odd = (place & bit) > 0
        entries = [where(odd, entries[i + 1], entries[i]) for i in range(0, len(entries), 2)]
        bit *= 2
    return entries[0]
