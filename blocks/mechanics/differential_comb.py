"""Differential comb with fringe: C1 = C' (overlap + x), C2 = C' (overlap - x), F = C' (V1^2 - V2^2) / 2.

C' = 2 N eps0 (h + fringe e) / g of N fingers of height h, each with a gap g on both of its sides.
The field at the upper and the lower edges counts as more height, e = ((g + t) ln(1 + 2 g / t) + g
ln(t (2 g + t) / g^2)) / pi for fingers of thickness t in a long row: the map of Schwarz and
Christoffel, to 1e-5 where h > 2 g, with nothing above or below. Neighbours share their fringe: two
plates by themselves have more. A comb that is pulled out has no capacitance and no force.
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import logarithm
from proofmass.blocks.declaration.declare import Block, Input, param

PERMITTIVITY = 8.8541878128e-12  # F/m, CODATA 2018


class DifferentialComb(Block):
    """Pair of area-varying combs by their geometry: capacitances of a readout, and force of the voltages on them."""

    fingers: int = param("1", "Fingers of either comb, N.", default=100, at_least=1, at_most=1_000_000)
    height: float = param("m", "Height of a finger, h.", default=25e-6, above=0.0)
    gap: float = param("m", "Gap on each side of a finger, g.", default=3e-6, above=0.0)
    thickness: float = param("m", "Thickness of a finger, across the gaps, t.", default=3e-6, above=0.0)
    overlap: float = param("m", "Overlap of the fingers at rest.", default=20e-6, above=0.0)
    fringe: float = param("1", "Part of the fringe field that counts: 0 for none.", default=1.0, at_least=0.0)

    displacement = Input("m", "Displacement x, into the first comb.")
    first_voltage = Input("V", "Voltage V1 of the first comb against the mass.", default=0.0)
    second_voltage = Input("V", "Voltage V2 of the second comb against the mass.", default=0.0)


class Constants(NamedTuple):
    gradient: float  # F/m
    overlap: float


@DifferentialComb.constants
def constants(p: DifferentialComb, period: float) -> Constants:
    gap, thickness = p.gap, p.thickness
    edges = (gap + thickness) * logarithm(1.0 + 2.0 * gap / thickness)
    edges = (edges + gap * logarithm(thickness * (2.0 * gap + thickness) / (gap * gap))) / math.pi
    return Constants(2.0 * float(p.fingers) * PERMITTIVITY * (p.height + p.fringe * edges) / gap, p.overlap)


@DifferentialComb.output("F")
def first(c: Constants, displacement: float) -> float:
    """Capacitance of the first comb, C1."""
    inside = c.overlap + displacement
    return c.gradient * (inside if inside > 0.0 else 0.0)


@DifferentialComb.output("F")
def second(c: Constants, displacement: float) -> float:
    """Capacitance of the second comb, C2."""
    inside = c.overlap - displacement
    return c.gradient * (inside if inside > 0.0 else 0.0)


@DifferentialComb.output("N")
def force(c: Constants, displacement: float, first_voltage: float, second_voltage: float) -> float:
    """Force on the mass, into the first comb."""
    pull = first_voltage * first_voltage if c.overlap + displacement > 0.0 else 0.0
    back = second_voltage * second_voltage if c.overlap - displacement > 0.0 else 0.0
    return 0.5 * c.gradient * (pull - back)


@DifferentialComb.corner
def within_first(c: Constants, displacement: float) -> float:
    return c.overlap + displacement


@DifferentialComb.corner
def within_second(c: Constants, displacement: float) -> float:
    return c.overlap - displacement
