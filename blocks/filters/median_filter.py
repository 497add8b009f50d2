"""Median filter: y[n] = the middle one of u[n], u[n-1], ... u[n-length+1], sorted; zero before tick 0.

The samples are kept in order, so that a tick takes `length` comparisons at most (Huang, Yang and
Tang, IEEE Trans. ASSP 27, 1979).
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import clip
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class MedianFilter(Block):
    """Takes out spikes shorter than half its length and keeps edges."""

    length: int = param("1", "Samples, an odd number.", default=5, at_least=1, at_most=9999)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to filter.")

    line = Buffer("The last samples.", float, ("length",))
    ordered = Buffer("The last samples, the smallest first.", float, ("length",))


class State(NamedTuple):
    oldest: int  # its place in the line


@MedianFilter.requires
def requires(p: MedianFilter) -> Iterator[tuple[str, str]]:
    if p.length % 2 == 0:
        yield "length", "an odd number"


@MedianFilter.output("{unit}")
def median(p: MedianFilter, x: State, line: list[float], ordered: list[float], input: float) -> float:
    """The median of this sample and those before."""
    middle = len(ordered) // 2
    if middle == 0:
        return input
    left = line[x.oldest]  # without it, the median is the input between two middle samples
    below = ordered[middle - 1] if ordered[middle - 1] < left else ordered[middle]
    above = ordered[middle] if ordered[middle] < left else ordered[middle + 1]
    return clip(input, below, above)


@MedianFilter.update
def update(p: MedianFilter, x: State, line: list[float], ordered: list[float], input: float) -> State:
    left, last, i = line[x.oldest], len(ordered) - 1, 0
    while i < last and ordered[i] < left:
        i += 1
    while i < last and ordered[i + 1] < input:
        ordered[i] = ordered[i + 1]
        i += 1
    while i > 0 and ordered[i - 1] > input:
        ordered[i] = ordered[i - 1]
        i -= 1
    ordered[i] = input
    line[x.oldest] = input
    return State(x.oldest + 1 if x.oldest < last else 0)
