"""The coordinates of a box of tolerances: each is a parameter or a named value, or one divided by it.

The stiffness over a mass bends less along 1/m than along m: the straighter of both is taken.

Parameters that act on a loop as one product are one coordinate (`products`).

Of a whole box some part is proved in a box of its own, which is larger where parameters change
slowly.
"""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.formulas.operations import OPERATIONS
from proofmass.graphs.model.adjustable import Adjustable
from proofmass.graphs.model.graph import split
from proofmass.runner.derivatives.dual_functions import for_duals
from proofmass.runner.design.proof.closed_loop import OpenCorners
from proofmass.runner.design.proof.half_plane import PoleRegion
from proofmass.runner.design.worst.ranges import Range
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.planned import Plan

Sides = tuple[tuple[float, float], ...]
_ROUNDED = 1.0 + 2.0**-40  # more than the rounding of a product of powers
_OVERLAP = 0.5  # of the width of a core, at both ends: what is wider dwells longer, but has less room for a norm


@dataclass(frozen=True)
class ProductRange(Range):
    """A range of a product of parameters to some powers, as one of its first factor alone, which has a power of 1."""

    factors: tuple[Range, ...] = ()
    powers: tuple[float, ...] = ()

    @classmethod
    def of(cls, factors: Sequence[Range], powers: Sequence[float]) -> "ProductRange":
        """Return the product of ranges without zero, all of which but the first stay as they are."""
        first, ends = factors[0], [_ends(r, power) for r, power in zip(factors, powers, strict=True)]
        low, high = (math.prod(r[i] ** power for r, power in zip(ends, powers, strict=True)) for i in (0, 1))
        least, most = sorted((first.nominal * low / _ROUNDED, first.nominal * high * _ROUNDED))
        of = tuple(factors), tuple(powers)
        return cls(first.name, first.written, first.unit, first.nominal, least, most, (), *of)

    def named(self, value: float) -> dict[str, float]:
        """Return factors whose product is that of the first at a value: all have gone the same part of their ways."""
        low, value, high = sorted((self.low / self.nominal, value / self.nominal, self.high / self.nominal))
        part = math.log(value / low) / math.log(high / low)
        ends = zip(self.factors, map(_ends, self.factors, self.powers), strict=True)
        values = {r: r.nominal * a ** (1.0 - part) * b**part for r, (a, b) in ends}
        return {r.written: min(max(value, r.low), r.high) for r, value in values.items()}


def _ends(of: Range, power: float) -> tuple[float, float]:
    """Return the ends of a range in units of what is nominal, that first at which a power of it is least."""
    low, high = sorted((of.low / of.nominal, of.high / of.nominal), reverse=power < 0.0)
    return low, high


@dataclass(frozen=True)
class Coordinates:
    """Ranges of parameters as sides of a box."""

    plan: Plan
    adjustable: Adjustable
    ranges: tuple[Range, ...]
    inverse: tuple[bool, ...]  # whether a coordinate is one divided by the parameter
    places: frozenset[str] = frozenset()  # names of those that are no parameters, but places of what is remembered

    def beside(self, places: Sequence[Range]) -> "Coordinates":
        """Return the coordinates with some of places after them."""
        inverse, names = (False,) * len(places), frozenset(r.name for r in places)
        return replace(self, ranges=(*self.ranges, *places), inverse=(*self.inverse, *inverse), places=names)

    def merged(self, product: "ProductRange", places: Sequence[int]) -> "Coordinates":
        """Return the coordinates with a product in the place of its first factor, and without the others."""
        kept = [place for place in range(len(self.ranges)) if place not in places[1:]]
        ranges = [product if place == places[0] else self.ranges[place] for place in kept]
        return replace(self, ranges=tuple(ranges), inverse=tuple(self.inverse[place] for place in kept))

    @property
    def tolerances(self) -> tuple[Range, ...]:
        """The ranges of all parameters and places, those of the factors of a product one by one."""
        return tuple(one for r in self.ranges for one in (r.factors if isinstance(r, ProductRange) else (r,)))

    def box(self) -> Sides:
        """Return the ends of each coordinate."""
        ends = (
            (r.low, r.high) if not turned else _turned(r) for r, turned in zip(self.ranges, self.inverse, strict=True)
        )
        return tuple(ends)

    def as_data(self) -> list[dict[str, Any]]:
        """Return the coordinates as plain data, for certificates."""
        return [
            {"name": r.written, "unit": r.unit, "inverse": inverse, "low": low, "high": high, **_product(r)}
            for r, inverse, (low, high) in zip(self.ranges, self.inverse, self.box(), strict=True)
        ]

    def changes(self, rates: Sequence[float], period: float) -> tuple[float, ...]:
        """Return at least how far each coordinate moves in a period, by the rates of its parameters in their units."""
        if not rates:
            return ()
        pairs = zip(self.ranges, self.inverse, strict=True)
        least = [min(abs(r.low), abs(r.high)) if turned else 1.0 for r, turned in pairs]
        each = itertools.zip_longest(rates, least, fillvalue=0.0)
        return tuple(rate * period / size**2 * (1.0 + 2.0**-48) for rate, size in each)

    def parameters(self, values: Sequence[Any]) -> Mapping[str, Any]:
        """Return moving parameters at values of the coordinates: numbers, balls or duals."""
        given = {
            r.name: 1.0 / value if turned else value
            for r, turned, value in zip(self.ranges, self.inverse, values, strict=True)
        }
        places = {name: given.pop(name) for name in self.places}
        return {
            **self.adjustable.settings(given, lambda name, values: for_duals(OPERATIONS[name].function)(*values)),
            **places,
        }

    def named(self, values: Sequence[float]) -> dict[str, float]:
        """Return numbers of parameters by their written names, at numbers of the coordinates."""
        named = dict[str, float]()
        for r, turned, value in zip(self.ranges, self.inverse, values, strict=False):
            own = 1.0 / value if turned else value
            named |= r.named(own) if isinstance(r, ProductRange) else {r.written: own}
        return named

    def turned(self, place: int) -> "Coordinates":
        """Return the same ranges with one coordinate inverted, if it is a parameter and zero is not in its range."""
        inverse = [
            turned != (i == place and r.low * r.high > 0.0 and r.name not in self.places)
            for i, (r, turned) in self._numbered()
        ]
        return replace(self, inverse=tuple(inverse))

    def _numbered(self) -> Iterator[tuple[int, tuple[Range, bool]]]:
        return enumerate(zip(self.ranges, self.inverse, strict=True))


def coordinates_of(plan: Plan, ranges: Sequence[Range]) -> Coordinates:
    """Return the coordinates of ranges; raises `ModelError` for what a proof cannot vary."""
    adjustable = Adjustable(plan.graph)
    found = Coordinates(plan, adjustable, tuple(ranges), (False,) * len(ranges))
    moving = {step.target for step in adjustable.dependence.followers([r.name for r in ranges])}
    problems = [_refused(r, "follows what varies too by a formula") for r in ranges if r.name in moving]
    if not problems:
        moved = adjustable.settings({r.name: r.nominal for r in ranges})
        odd = [name for name in moved if split(name)[0] not in plan.blocks or name.endswith(".rate")]
        problems += [
            Problem(message="a rate may not vary with tolerances", key=name, path=("tolerances",)) for name in odd
        ]
    if problems:
        raise ModelError([plan.graph.placed(problem) for problem in problems])
    return found


def _product(of: Range) -> dict[str, Any]:
    """Return the factors of a product as plain data."""
    if not isinstance(of, ProductRange):
        return {}
    factors = [
        {"name": r.written, "unit": r.unit, "low": r.low, "high": r.high, "nominal": r.nominal, "power": power}
        for r, power in zip(of.factors, of.powers, strict=True)
    ]
    return {"nominal": of.nominal, "product": factors}


def _turned(wanted: Range) -> tuple[float, float]:
    """Return the ends of one divided by a range, a little further apart than rounding."""
    ends = 1.0 / wanted.high, 1.0 / wanted.low
    return ends[0] - 2.0**-50 * abs(ends[0]), ends[1] + 2.0**-50 * abs(ends[1])


def _refused(wanted: Range, why: str) -> Problem:
    key = f"tolerances.{wanted.written}"
    hint = "prove tolerances of parameters; `proofmass worst` searches everything that a study varies"
    return Problem(message=why, key=key, hint=hint, path=("tolerances", wanted.written))


@dataclass(frozen=True)
class ProvedRegion:
    """A part of a whole in a box that contracts, and its norm."""

    core: Sides  # of the part of the whole that it covers
    box: Sides  # that contracts: the core, with room about it where parameters change slowly
    transform: Array  # T
    beyond: Array  # bounds of how far matrices may lie beyond the corners, entry by entry
    bends: float  # and more, by their norm in coordinates of T
    shift: Array | None  # by which the corners are moved before
    left: Array | None  # what a matrix at rest was multiplied by
    beyond_noise: Array | None
    loops: OpenCorners  # opened, of the parameters of the box; without derivatives
    disc: PoleRegion  # in which all poles lie


def widened(core: Sides, whole: Sides, changes: Sequence[float]) -> Sides:
    """Return the box of a core within a whole, with room along each coordinate that moves."""
    rooms = [_OVERLAP * (high - low) * (move > 0.0) for (low, high), move in zip(core, (*changes, 0.0), strict=True)]
    sides = zip(core, whole, rooms, strict=True)
    return tuple((max(first, low - room), min(last, high + room)) for (low, high), (first, last), room in sides)
