"""A part of a whole that is proved, in a box that is larger where parameters change slowly."""

from collections.abc import Sequence
from dataclasses import dataclass

from proofmass.runner.design.proof.closed_loop import OpenCorners
from proofmass.runner.design.proof.coordinates import Sides
from proofmass.runner.design.proof.half_plane import PoleRegion
from proofmass.runner.host.arrays import Array

_OVERLAP = 0.5  # of the width of a core, at both ends: what is wider dwells longer, but has less room for a norm


@dataclass(frozen=True)
class ProvedRegion:
    """A part of a whole in a box that contracts, and its norm."""

    core: Sides  # of the part of the whole that it covers
    box: Sides  # that contracts: the core, with room about it where parameters change slowly
    transform: Array  # T
    beyond: Array  # bounds of how far matrices may lie beyond the corners
    left: Array | None  # what a matrix at rest was multiplied by
    beyond_noise: Array | None
    loops: OpenCorners  # opened, of the parameters of the box; without derivatives
    disc: PoleRegion  # in which all poles lie


def widened(core: Sides, whole: Sides, changes: Sequence[float]) -> Sides:
    """Return the box of a core within a whole, with room along each coordinate that moves."""
    rooms = [_OVERLAP * (high - low) * (move > 0.0) for (low, high), move in zip(core, (*changes, 0.0), strict=True)]
    sides = zip(core, whole, rooms, strict=True)
    return tuple((max(first, low - room), min(last, high + room)) for (low, high), (first, last), room in sides)
