"""Squeeze-film damping of a rectangular plate: F = -c v, c = b m L W^3 / h^3 at rest, m the viscosity, L >= W.

b = 1 - 192 / pi^5 W / L sum of tanh(n pi L / (2 W)) / n^5 over odd n: 1 for a long strip, 0.42 for
a square (Bao, Analysis and Design Principles of MEMS Devices, 2005, section 3.3). Towards a wall c
grows as 1 / (1 - x / h)^3; with a wall on both sides the two add up. For slow motion of plates
without holes: the film has no stiffness.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import hyperbolic_tangent
from proofmass.blocks.declaration.declare import Block, Input, param

SERIES = 0.6274106194662501  # 192 / pi^5
_TOUCH = "the plates touch: give the mass stops within the gap, as MassBetweenStops has"


class SqueezeFilmDamping(Block):
    """Force of the gas between a plate and the wall that it moves to."""

    length: float = param("m", "Longer side of the plate, L.", default=1e-3, above=0.0)
    width: float = param("m", "Shorter side, W.", default=1e-3, above=0.0)
    gap: float = param("m", "Gap at rest, h.", default=4e-6, above=0.0)
    viscosity: float = param("Pa*s", "Viscosity of the gas, m: of air 18 uPa s.", default=18.0e-6, at_least=0.0)
    both_sides: bool = param("", "Whether there is a wall on the other side as well.", default=True)

    displacement = Input("m", "Displacement towards the wall.")
    velocity = Input("m/s", "Velocity towards the wall.")


class Constants(NamedTuple):
    damping: float
    gap: float
    both_sides: bool


@SqueezeFilmDamping.requires
def requires(p: SqueezeFilmDamping) -> Iterator[tuple[str, str]]:
    if p.width > p.length:
        yield "width", f"at most length = {p.length:g}"


@SqueezeFilmDamping.constants
def constants(p: SqueezeFilmDamping, period: float) -> Constants:
    long = p.length / p.width
    total = 0.0
    for n in (1.0, 3.0, 5.0, 7.0, 9.0):
        total += hyperbolic_tangent(0.5 * math.pi * n * long) / (n * n * n * n * n)
    shape = 1.0 - SERIES / long * total
    s = p.width / p.gap
    return Constants(shape * p.viscosity * p.length * s * s * s, p.gap, p.both_sides)


@SqueezeFilmDamping.output("N", no_value=_TOUCH)
def force(c: Constants, displacement: float, velocity: float) -> float:
    """Force on the plate."""
    near, far = 1.0 - displacement / c.gap, 1.0 + displacement / c.gap
    if near <= 0.0 or (c.both_sides and far <= 0.0):
        return math.nan
    both = 1.0 / (near * near * near) + (1.0 / (far * far * far) if c.both_sides else 0.0)
    return -c.damping * both * velocity
