"""Formats of fixed-point numbers: how many bits, and where the binary point is."""

import re
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

MOST_BITS = 512  # of a format: far beyond any register, small enough no shift can fill the memory
_NOTATION = re.compile(r"\(\s*(\d{1,4})\s*,\s*([+-]?\d{1,4})\s*\)(\s+unsigned)?")


@dataclass(frozen=True, repr=False)
class Fixed:
    """A fixed-point format: `width` bits in all, the sign included, `fraction` of them after the binary point.

    Written "(32, 30)" in System Generator's notation: -2 to almost 2 in steps of 2**-30; "(8, 0)
    unsigned" is 0 to 255. `fraction` may be negative or exceed the width. Raises ValueError for a
    width or fraction out of bounds.

    >>> Fixed(16, 12).lowest, Fixed(16, 12).highest, Fixed(16, 12).resolution
    (-32768, 32767, Fraction(1, 4096))
    """

    width: int
    fraction: int = 0
    signed: bool = True

    def __post_init__(self) -> None:
        if not 1 <= self.width <= MOST_BITS:
            raise ValueError(f"a format of {self.width} bits: the width is 1 to {MOST_BITS}")
        if abs(self.fraction) > MOST_BITS:
            raise ValueError(f"a format with {self.fraction} fraction bits: they are -{MOST_BITS} to {MOST_BITS}")

    @classmethod
    def read(cls, text: str) -> "Fixed":
        """The format named by a text; raises ValueError."""
        found = _NOTATION.fullmatch(text.strip())
        if found is None:
            raise ValueError("is not a format")
        return cls(int(found[1]), int(found[2]), signed=found[3] is None)

    @cached_property
    def lowest(self) -> int:
        """The lowest mantissa."""
        return -(1 << (self.width - 1)) if self.signed else 0

    @cached_property
    def highest(self) -> int:
        """The highest mantissa."""
        return (1 << (self.width - 1 if self.signed else self.width)) - 1

    @property
    def resolution(self) -> Fraction:
        """The value of one step of the mantissa."""
        return Fraction(2) ** -self.fraction

    @cached_property
    def with_range(self) -> str:
        """The format and the values that it holds, in words.

        >>> Fixed(8, 4).with_range
        'Fixed(8, 4), which holds -8 to 7.9375'
        """
        return f"{self!r}, which holds {self.shown(self.lowest)} to {self.shown(self.highest)}"

    def shown(self, mantissa: int) -> str:
        """The value of a mantissa, for a message."""
        value = mantissa * self.resolution
        return f"{float(value):.10g}" if abs(value) < 10**300 else "a number of over 300 digits"

    def __repr__(self) -> str:
        return f"Fixed({self.width}, {self.fraction}{'' if self.signed else ', signed=False'})"

    def __str__(self) -> str:
        return f"({self.width}, {self.fraction}){'' if self.signed else ' unsigned'}"
