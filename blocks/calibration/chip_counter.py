"""Chip counter: chip = n mod chips, window = first <= chip <= last, end = chip = chips - 1.

The shift register that starts with all its L cells ones gives L ones first: within that window the
force on the device is constant (Sarraf et al. 2012, section 2.1, steps ii and iv).
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, param


class ChipCounter(Block):
    """Counts the chips of a pseudorandom sequence, in step with its register."""

    chips: int = param("1", "Chips of a period.", default=1023, at_least=1)
    first: int = param("1", "First chip of the window.", default=1, at_least=0)
    last: int = param("1", "Last chip of the window.", default=10, at_least=0)


class State(NamedTuple):
    chip: int


@ChipCounter.requires
def requires(p: ChipCounter) -> Iterator[tuple[str, str]]:
    if p.last >= p.chips:
        yield "last", f"less than chips = {p.chips}"
    if p.first > p.last:
        yield "first", f"at most last = {p.last}"


@ChipCounter.output("1")
def chip(p: ChipCounter, x: State) -> int:
    """Number of the chip, from 0."""
    return x.chip


@ChipCounter.output("1")
def window(p: ChipCounter, x: State) -> bool:
    """True from the first to the last chip of the window, both included."""
    return p.first <= x.chip and x.chip <= p.last


@ChipCounter.output("1")
def end(p: ChipCounter, x: State) -> bool:
    """True in the last chip of a period."""
    return x.chip == p.chips - 1


@ChipCounter.update
def update(p: ChipCounter, x: State) -> State:
    return State(0 if x.chip == p.chips - 1 else x.chip + 1)
