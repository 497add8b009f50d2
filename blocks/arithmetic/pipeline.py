"""Pipeline cuts: y = pipe(x) is x in every simulation, and a register in hardware.

A cut splits a long path of logic in two, so that the clock may be faster, and the result comes a
tick later. What it is combined with is made as late by registers of its own, and the block says how
many ticks its outputs are late. In a path that comes back to the register that it starts from, a
cut would change what is computed, and is refused.
"""

from typing import Any

from proofmass.blocks.arithmetic.fixed_point import FixedValue


def pipe(value: Any) -> Any:
    """Return the value itself: a FixedValue, an integer or a truth value. A pipeline register may be put here.

    >>> pipe(FixedValue(3, 4)), pipe(True)
    (FixedValue(3, 4), True)
    """
    if isinstance(value, FixedValue):
        return FixedValue(pipe(value.mantissa), value.fraction)
    return value if isinstance(value, int | float) else value.cut()  # a signal of a trace keeps the cut for hardware
