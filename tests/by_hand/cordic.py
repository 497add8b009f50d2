"""The fixed-point exponential of Liu, Li and Shen in plain integers, and blocks swept over many inputs.

Everything here takes Python integers or arrays of them; constants come from mpmath.
"""

import functools
from typing import Any

import mpmath
import numpy as np

from proofmass.blocks.declaration.declare import Block
from proofmass.runner.fixed.digital import digital_block
from tests.by_hand.compiled import over_columns
from tests.by_hand.integer_code import Code

mpmath.mp.dps = 60
ROWS = 300  # a compilation takes as long as so many interpreted ones


@functools.lru_cache
def scaled(value: Any, bits: int) -> int:
    """round(value 2^bits)."""
    return int(mpmath.nint(mpmath.mpf(value) * 2**bits))


def shifts(iterations: int) -> list[int]:
    """1 to n; 4, 13 and 40 twice."""
    return sorted([*range(1, iterations + 1), *(i for i in (4, 13, 40) if i <= iterations)])


def growth(iterations: int) -> Any:
    return mpmath.fprod(mpmath.sqrt(1 - mpmath.mpf(4) ** -i) for i in shifts(iterations))


def rotated(start: Any, angle: Any, bits: int, iterations: int) -> Any:
    """X after all rotations; `bits` are those of the angle."""
    x, z = start, angle
    for i in shifts(iterations):
        d = 2 * (z >= 0) - 1
        x, z = x + d * (x >> i), z - d * scaled(mpmath.atanh(mpmath.mpf(2) ** -i), bits)
    return x


def exponential(angle: Any, bits: int, iterations: int, guard: int = 0) -> Any:
    """exp(angle) with `bits` fraction bits, for an angle with as many."""
    start = scaled(1 / growth(iterations), bits + guard)
    return rotated(start + 0 * angle, angle << guard, bits + guard, iterations) >> guard


def reduced(exponent: Any, bits: int) -> tuple[Any, Any, Any]:
    """The product A, octave and remainder."""
    product = exponent * scaled(1 / mpmath.log(2), bits)
    fraction = (product >> bits) & (2**bits - 1)
    return product, product >> 2 * bits, (fraction * scaled(mpmath.log(2), bits)) >> bits


def shifted(mantissa: Any, octave: Any) -> Any:
    """mantissa 2^octave, bits below the last dropped."""
    return (mantissa << np.maximum(octave, 0)) >> np.maximum(-octave, 0)


def chain(temperature: Any, a: float, b: float, bits: int, further: int = 0, preload: bool = False) -> Any:
    """a exp(b T), with bits + further fraction bits: three multipliers where `a` is preloaded, four where it is not."""
    _, octave, angle = reduced((scaled(b, bits) * temperature) >> bits, bits)
    if preload:
        start = scaled(a / growth(bits), bits + further)
        return shifted(rotated(start + 0 * angle, angle, bits, bits), octave)
    return (scaled(a, bits + further) * shifted(exponential(angle, bits, bits), octave)) >> bits


def swept(block: Block, output: str, *columns: Any) -> Any:
    """Mantissas of an output for columns of mantissas of its inputs, by the integer code of the compiled loop.

    Few rows are interpreted, sooner than the code compiles.
    """
    made = digital_block("block", block, 1.0)
    step = made.steps[output]
    before = (made.constants, *(None for name in type(block).output_functions[output].arguments if name == "p"))
    flagged = step.overflows or step.refuses

    code = Code(step.code)
    if len(columns[0]) > ROWS:
        return over_columns(code, *columns, before=before)[0]
    rows = (code(*before, *row) for row in zip(*(column.tolist() for column in columns), strict=True))
    return np.array([row[0] if flagged else row for row in rows], dtype=np.int64)
