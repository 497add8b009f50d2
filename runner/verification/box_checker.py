"""Checks of boxes of a certificate: that leaves cover all of one, and a side all of a product."""

from collections.abc import Mapping, Sequence
from decimal import Decimal
from typing import Any

LeafBox = tuple[tuple[float, float], ...]


def named_side(side: Mapping[str, Any]) -> tuple[str, bool]:
    """Return what varies along a side in words, and whether all of it is within its ends.

    A product is that of its factors, in units of what each is nominally, to their powers.
    """
    factors, ends, sign = side.get("product", []), [Decimal(side.get("nominal", 0))] * 2, -1 if side["inverse"] else 1
    for one in factors:
        ways = [(Decimal(one[end]) / Decimal(one["nominal"])).ln() * Decimal(one["power"]) for end in ("low", "high")]
        ends = [ends[0] * min(ways).exp(), ends[1] * max(ways).exp()]
    words = [f"{one['name']} from {one['low']:g} to {one['high']:g}" for one in factors or [side]]
    within = (
        not factors or side["low"] <= min(end**sign for end in ends) <= max(end**sign for end in ends) <= side["high"]
    )
    return "1 / " * (side["inverse"] and not factors) + ", ".join(words), within


def covered(whole: LeafBox, boxes: Sequence[LeafBox]) -> bool:
    """Return whether boxes that came of halving cover all of a box."""
    for place, (low, high) in enumerate(whole):
        middle = 0.5 * low + 0.5 * high
        below, above = ([b for b in boxes if b[place][1] <= middle], [b for b in boxes if b[place][0] >= middle])
        if low < middle < high and len(below) + len(above) == len(boxes) and below and above:
            halves = ((low, middle), below), ((middle, high), above)
            return all(covered((*whole[:place], side, *whole[place + 1 :]), some) for side, some in halves)
    return whole in boxes
