"""Linear feedback shift register in Fibonacci form: a[n] = xor of a[n - tap] (Sarraf et al. 2012, section 2.1)."""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, param

# Taps of one primitive polynomial per length: bit i stands for a[n - (i + 1)].
PRIMITIVE_TAPS = {
    2: 0x3, 3: 0x6, 4: 0xC, 5: 0x14, 6: 0x30, 7: 0x60, 8: 0xB8, 9: 0x110, 10: 0x240, 11: 0x500, 12: 0xE08,
    13: 0x1C80, 14: 0x3802, 15: 0x6000, 16: 0xD008, 17: 0x12000, 18: 0x20400, 19: 0x72000, 20: 0x90000,
    21: 0x140000, 22: 0x300000, 23: 0x420000, 24: 0xE10000,
}  # fmt: skip


class ShiftRegister(Block):
    """Maximal-length pseudorandom bits: the period is 2^length - 1 when the taps are a primitive polynomial."""

    length: int = param("bit", "Cells in the register.", default=10, at_least=2, at_most=24)
    taps: int = param("1", "Cells summed modulo 2 into the feedback: bit i for a[n-i-1].", default=0x240, at_least=1)
    seed: int = param("1", "Cells at the start, never all zero.", default=0x3FF, at_least=1)


class State(NamedTuple):
    cells: int


class Constants(NamedTuple):
    taps: int
    mask: int
    last: int


@ShiftRegister.requires
def requires(p: ShiftRegister) -> Iterator[tuple[str, str]]:
    if p.taps >= 1 << p.length:
        yield "taps", f"taps within {p.length} cells; {PRIMITIVE_TAPS[p.length]} is primitive"
    elif not p.taps >> (p.length - 1):
        yield "taps", f"the last of {p.length} cells among the taps; {PRIMITIVE_TAPS[p.length]} is primitive"
    if p.seed >= 1 << p.length:
        yield "seed", f"1 to {(1 << p.length) - 1}"


@ShiftRegister.constants
def constants(p: ShiftRegister, period: float) -> Constants:
    return Constants(p.taps, (1 << p.length) - 1, p.length - 1)


@ShiftRegister.start
def start(p: ShiftRegister) -> State:
    return State(p.seed)


@ShiftRegister.output("1")
def bit(c: Constants, x: State) -> bool:
    """Oldest cell of the register."""
    return (x.cells >> c.last) & 1 == 1


@ShiftRegister.update
def update(c: Constants, x: State) -> State:
    parity = x.cells & c.taps
    parity ^= parity >> 16
    parity ^= parity >> 8
    parity ^= parity >> 4
    parity = (0x6996 >> (parity & 15)) & 1
    return State(((x.cells << 1) | parity) & c.mask)
