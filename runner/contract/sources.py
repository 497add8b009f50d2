"""Sources of numbers for blocks under test: ordinary ones, and ones that arithmetic trips over."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, param


class Draws(Block):
    """A linear congruential generator: random numbers that plain Python makes ten times sooner than white noise."""

    seed: int = param("1", "State at tick 0.", default=1, at_least=0)
    unit: str = param("", "Unit of the output.", default="1")
    scale: float = param("{unit}", "About what the numbers are.", default=1.0)


class DrawnState(NamedTuple):
    number: int


@Draws.start
def start(p: Draws) -> DrawnState:
    return DrawnState(p.seed)


@Draws.output("{unit}")
def output(p: Draws, x: DrawnState) -> float:
    """Number about zero: small ones more often than large ones, the largest five scales."""
    even = x.number / 2**30 - 1.0
    return 5.0 * p.scale * even * even * even


@Draws.update
def update(p: Draws, x: DrawnState) -> DrawnState:
    return DrawnState((1103515245 * x.number + 12345) % 2**31)


NUMBERS = (
    0.0, -0.0, 1.0, -1.0, 0.5, 3.0, -7.3, 5e-324, -5e-324, 2.2250738585072014e-308, 1e-200, -1e-160, 1e-9, 1e9,
    4503599627370495.5, 9007199254740993.0, 9.223372036854775e18, -9.223372036854775808e18, 1e19, 1e160, -1e200,
    1e308, -1.7976931348623157e308, 710.0, -745.2,
)  # fmt: skip
INTEGERS = (
    0, 1, -1, 2, -2, 3, 7, -10, 63, 64, -64, 1000, 2147483648, -4294967296, 3037000500, 9007199254740993,
    4611686018427387904, -4611686018427387904, 9223372036854775807, 9223372036854775806, -9223372036854775808,
)  # fmt: skip


class HostileNumbers(Block):
    """Numbers by chance: every other one zero, tiny, huge, or at an edge of arithmetic, but finite, as wires are."""

    seed: int = param("1", "State at tick 0.", default=1, at_least=0)
    unit: str = param("", "Unit of the output.", default="1")
    scale: float = param("{unit}", "About what the ordinary numbers are.", default=1.0)


class HostileIntegers(Block):
    """Integers by chance: every other one at an edge of 64 bits, shifts, or exact conversion."""

    seed: int = param("1", "State at tick 0.", default=1, at_least=0)
    unit: str = param("", "Unit of the output.", default="1")


@HostileNumbers.output("{unit}")
def number(p: HostileNumbers, x: DrawnState) -> float:
    """An ordinary number, or one of the table."""
    if (x.number >> 16) % 2 == 0:
        return p.scale * (x.number / 2**30 - 1.0)
    return NUMBERS[(x.number >> 17) % len(NUMBERS)]


@HostileIntegers.output("{unit}")
def integer(p: HostileIntegers, x: DrawnState) -> int:
    """A small integer, or one of the table."""
    if (x.number >> 16) % 2 == 0:
        return (x.number >> 20) - 1024
    return INTEGERS[(x.number >> 17) % len(INTEGERS)]


for kind in (HostileNumbers, HostileIntegers):
    kind.start(start)
    kind.update(update)
