"""A function of a shared library that a generated loop calls."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class CFunction:
    """A function of so many 64-bit integers that returns one, or nothing.

    Machine code that is kept knows it by `symbol`, which must stand for the same code in every process; its address
    there is another each time, and no part of what it is.
    """

    symbol: str
    arguments: int
    returns: bool
    address: int = field(compare=False, repr=False)
