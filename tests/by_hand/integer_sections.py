"""Second-order sections in plain integers, written anew: y = round((b u - a1 y1 - a2 y2) / 2^f), in w bits that wrap.

All start states at once, for limit cycles of zero input; all states that can be reached, for overflows.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from math import floor

import numpy as np
from numpy.typing import NDArray

from proofmass import Graph
from proofmass.blocks import Constant, FixedQuantiser, FixedSecondOrderSection
from proofmass.blocks.arithmetic.fixed_point import Fixed

INPUT = Fixed(12, 0)


@dataclass(frozen=True)
class Section:
    """Coefficients in steps of 2^-f, the bits of y, and a rule of rounding."""

    b: int
    a1: int
    a2: int
    f: int
    bits: int
    rounding: str = "half_even"
    overflow: str = "wrap"

    @property
    def most(self) -> int:
        """The largest y."""
        return (1 << (self.bits - 1)) - 1

    def graph(self) -> Graph:
        """Return the section after a quantiser of unit steps, with an input of 0."""
        step, y = 2.0**-self.f, Fixed(self.bits, 0)
        section = FixedSecondOrderSection(
            b0=self.b * step,
            b1=0.0,
            b2=0.0,
            a1=self.a1 * step,
            a2=self.a2 * step,
            coefficient_format=Fixed(self.f + 4, self.f),
            input_format=INPUT,
            state_format=y,
            output_format=y,
            rounding=self.rounding,
            overflow=self.overflow,
        )
        return Graph(
            name="section",
            rate=1000,
            blocks={"input": Constant(value=0.0), "quantiser": FixedQuantiser(output_format=INPUT), "filter": section},
            wires=["input.output -> quantiser.input", "quantiser.output -> filter.input"],
            probes=["filter.output"],
        )

    def unlimited(self, u: int, y1: int, y2: int) -> int:
        """Return y before the register limits it."""
        exact = Fraction(self.b * u - self.a1 * y1 - self.a2 * y2, 1 << self.f)
        match self.rounding:
            case "half_even":
                return round(exact)
            case "half_up":
                return floor(exact + Fraction(1, 2))
            case "toward_zero":
                return int(exact)
            case _:
                return floor(exact)

    def largest_limit_cycle(self) -> int:
        """Return the largest y that comes back for ever after some start, where nothing overflows meanwhile.

        Each state leads to one other: as many steps as there are states end on a cycle, and go round all of it.
        """
        side = np.arange(-self.most - 1, self.most + 1, dtype=np.int64)
        y1, y2 = (one.ravel() for one in np.meshgrid(side, side))
        y = self._rounded(-self.a1 * y1 - self.a2 * y2)
        wrapped = (y + self.most + 1) % len(side) - self.most - 1
        after = (wrapped + self.most + 1) + len(side) * (y1 + self.most + 1)
        largest, overflowed = np.abs(y), wrapped != y
        for _ in range(len(y).bit_length()):  # twice as many steps each time
            largest, overflowed = np.maximum(largest, largest[after]), overflowed | overflowed[after]
            after = after[after]
        return int(largest[after][~overflowed[after]].max(initial=0))

    def overflows(self, inputs: Iterable[int]) -> bool:
        """Return whether some sequence of these inputs overflows y from rest: all states that can be reached."""
        inputs = list(inputs)
        known, new = {(0, 0)}, [(0, 0)]
        while new:
            y1, y2 = new.pop()
            for u in inputs:
                y = self.unlimited(u, y1, y2)
                if not -self.most - 1 <= y <= self.most:
                    return True
                if (y, y1) not in known:
                    known.add((y, y1))
                    new.append((y, y1))
        return False

    def overflows_at(self, inputs: Iterable[float]) -> int | None:
        """Return the number of the input with which y overflows for the first time."""
        y1 = y2 = 0
        for tick, u in enumerate(inputs):
            y = self.unlimited(int(u), y1, y2)
            if not -self.most - 1 <= y <= self.most:
                return tick
            y1, y2 = y, y1
        return None

    def size_at_end(self, inputs: Iterable[float]) -> int:
        """Return the largest of the last 50 y of a register that wraps."""
        y1 = y2 = 0
        last = []
        for u in inputs:
            y = (self.unlimited(int(u), y1, y2) + self.most + 1) % (2 * self.most + 2) - self.most - 1
            last.append(abs(y))
            y1, y2 = y, y1
        return max(last[-50:])

    def response(self, many: int) -> list[Fraction]:
        """Return what one unit of error in y at tick 0 makes of y."""
        y1 = y2 = Fraction(0)
        h = []
        for tick in range(many):
            y = Fraction(tick == 0) - (self.a1 * y1 + self.a2 * y2) / (1 << self.f)
            h.append(y)
            y1, y2 = y, y1
        return h

    def _rounded(self, scaled: NDArray[np.int64]) -> NDArray[np.int64]:
        below, rest = scaled >> self.f, scaled & ((1 << self.f) - 1)
        half = 1 << (self.f - 1)
        match self.rounding:
            case "half_even":
                return below + ((rest > half) | ((rest == half) & (below % 2 == 1)))
            case "half_up":
                return below + (rest >= half)
            case "toward_zero":
                return below + ((below < 0) & (rest > 0))
            case _:
                return below
