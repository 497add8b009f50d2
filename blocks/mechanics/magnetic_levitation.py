"""Pull of an electromagnet: F = C (i0 + i)^2 / (d - x)^2, C = mu0 N^2 A / 4.

N is the number of turns in all, and A the area of each of its two poles. The flux crosses two gaps
of d - x, as under a horseshoe or a radial bearing. A pair pulls with i0 - i and d + x the other
way. About i = 0, x = 0 one magnet has the gain 2 C i0 / d^2 and a negative stiffness of 2 C i0^2 /
d^3, and a pair twice both: without a controller the mass falls or sticks (Schweitzer and Maslen,
Magnetic Bearings, 2009, chapter 2).
"""

import math

from proofmass.blocks.declaration.declare import Block, Input, param

_TOUCH = "the mass touches the magnet: give it stops within the gap, as MassBetweenStops has, or less current"


class MagneticLevitation(Block):
    """Force of an electromagnet, or of a pair, on a mass that it holds without contact."""

    force_constant: float = param("N*m^2/A^2", "C: force times gap squared over current squared.", default=1e-10)
    gap: float = param("m", "Gap d at rest.", default=100e-6, above=0.0)
    bias: float = param("A", "Constant current i0.", default=0.1)
    push_pull: bool = param("", "Whether a second magnet pulls the other way with i0 - i.", default=False)

    current = Input("A", "Control current i on top of the bias.")
    displacement = Input("m", "Displacement x towards the magnet.")


@MagneticLevitation.output("N", no_value=_TOUCH)
def force(p: MagneticLevitation, current: float, displacement: float) -> float:
    """Force on the mass towards the magnet."""
    if displacement >= p.gap or (p.push_pull and displacement <= -p.gap):
        return math.nan
    near = (p.bias + current) / (p.gap - displacement)
    far = (p.bias - current) / (p.gap + displacement) if p.push_pull else 0.0
    return p.force_constant * (near * near - far * far)
