"""Designs of a study: which uniform deviate each sensor has for each spread parameter.

`random`: independent deviates. `latin_hypercube`: of n sensors each has a stratum of width 1/n of
its own in every parameter (McKay, Beckman and Conover, Technometrics 21 (1979)). `sobol`: points of
Sobol's sequence with the direction numbers of Joe and Kuo (2008), shifted in each parameter by a
random word, bit by bit. `saltelli`: points A and B of a Sobol sequence of twice the parameters, and
A with one parameter after the other from B, for Sobol indices (Saltelli et al., Computer Physics
Communications 181 (2010)).

A deviate is a pure function of (seed, sensor, name); in the second design also of the number of
sensors, in the last two of the names of all spread parameters.
"""

import zlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from proofmass.blocks.arithmetic.counter_random import philox, uniform_deviate

DESIGNS = ("random", "latin_hypercube", "sobol", "saltelli")
_BITS = 52  # of a deviate: odd multiples of 2^-53, as the random ones
_LARGEST = 1.0 - 2.0**-53
_ROUNDS = 6


def stream_of(what: str, name: str) -> int:
    """Number of a parameter's random stream: from its name alone; no block's name has a space."""
    return zlib.crc32(f"{what} {name}".encode())


@dataclass(frozen=True)
class Design:
    """The uniform deviates of a study."""

    kind: str
    names: tuple[str, ...]  # of the spread parameters, in alphabetical order
    sensors: int
    seed: int

    @property
    def group(self) -> int:
        """Sensors that differ in one parameter at a time, and share noise and drift."""
        return len(self.names) + 2 if self.kind == "saltelli" else 1

    def deviate(self, sensor: int, name: str) -> float:
        """The deviate between 0 and 1, both excluded, of one sensor in one parameter."""
        stream = stream_of("spread", name)
        if self.kind == "random":
            return uniform_deviate(self.seed, sensor, stream, 0)
        if self.kind == "latin_hypercube":
            stratum = permuted(sensor, self.sensors, half_of_bits(self.sensors), self.seed, stream)
            uniform: float = self.within(stratum, uniform_deviate(self.seed, sensor, stream, 0))
            return uniform
        place = self.names.index(name)
        if self.kind == "sobol":
            return self._shifted(sensor, place, stream)
        number, member = divmod(sensor, self.group)
        from_b = member == 1 or member == place + 2
        return self._shifted(number, place + len(self.names) * from_b, stream)

    def within(self, stratum: Any, uniform: Any, least: Callable[[Any, Any], Any] = min) -> Any:
        """A deviate in one of the strata of a Latin hypercube."""
        return least((stratum + uniform) / self.sensors, _LARGEST)

    def _shifted(self, number: int, dimension: int, stream: int) -> float:
        word0, word1, _, _ = philox(self.seed & 0xFFFFFFFF, self.seed >> 32, dimension, 0, stream, 0xFFFFFFFF)
        bits = int(self._points[number, dimension]) ^ (word0 << 20 | word1 >> 12)
        return (bits + 0.5) * 2.0**-_BITS

    @cached_property
    def _points(self) -> Any:
        """Sobol's points as integers of 52 bits."""
        # start-up time: scipy.stats takes 0.4 s
        from scipy.stats.qmc import Sobol

        groups = -(-self.sensors // self.group)
        dimensions = len(self.names) * (2 if self.kind == "saltelli" else 1)
        points = Sobol(dimensions, scramble=False, bits=_BITS).random_base2((groups - 1).bit_length())
        return (points * 2.0**_BITS).astype("uint64")


def half_of_bits(size: int) -> int:
    """Half of the smallest even number of bits, at least two, to hold numbers below a size."""
    return max(1, (size - 1).bit_length() + 1 >> 1)


def permuted(number: int, size: int, half: int, seed: int, stream: int) -> int:
    """Return the place that a random permutation of `size` numbers gives one of them, without the others.

    A Feistel network over words of `half_of_bits(size)`, its rounds keyed by Philox, until it falls
    below the size (Black and Rogaway, "Ciphers with arbitrary finite domains", CT-RSA 2002,
    cycle-walking).

    >>> sorted(permuted(k, 7, 2, 1, 2) for k in range(7))
    [0, 1, 2, 3, 4, 5, 6]
    """
    mask = (1 << half) - 1
    while True:
        left, right = number >> half, number & mask
        for turn in range(_ROUNDS):
            word, _, _, _ = philox(seed & 0xFFFFFFFF, seed >> 32, right, turn, stream, 0xFFFFFFFE)
            left, right = right, left ^ (word & mask)
        number = left << half | right
        if number < size:
            return number
