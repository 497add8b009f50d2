"""Weights of the bits of a converter whose elements do not match.

Bit i is made of 2^i unit elements, each off by a standard deviation s: it is off by s / sqrt(2^i)
of itself (Razavi, Principles of Data Conversion System Design, 1995, chapter 4). `device` names a
specimen, and so its draw.
"""

import math
from collections.abc import Sequence

from proofmass.blocks.arithmetic.counter_random import normal_deviate

_STREAM = 0x57454947  # "WEIG": no block of noise shares these deviates


def bit_weights(bits: int, errors: Sequence[float], mismatch: float, device: int) -> list[float]:
    """Weights in steps, that of the highest bit first; errors are relative, and those that are not
    given are zero.

    >>> bit_weights(3, (0.25,), 0.0, 1)
    [5.0, 2.0, 1.0]
    """
    weights = []
    for place in range(bits):
        ideal = float(1 << (bits - 1 - place))
        error = errors[place] if place < len(errors) else 0.0
        drawn = mismatch / math.sqrt(ideal) * normal_deviate(device, 0, _STREAM, place)
        weights.append(ideal * (1.0 + error + drawn))
    return weights
