"""Coriolis force of one mode of a vibratory gyroscope on the other: F = s 2 m Omega v (Sarraf et
al. 2012, section 3.3, equations 6 and 7; the paper prints dy/dt in both).

The sign s is +1 for the force on the drive mode and -1 for that on the sense mode: together they do
no work.
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class CoriolisForce(Block):
    """Force that rotation couples from the velocity of one mode into the other."""

    mass: float = param("kg", "Mass that moves in both modes.", default=48.67e-9, above=0.0)
    positive: bool = param("", "Whether the sign is +1 (on the drive mode) or -1 (on the sense mode).", default=False)

    velocity = Input("m/s", "Velocity of the other mode.")
    rotation = Input("rad/s", "Rate of rotation, Omega.")


@CoriolisForce.output("N")
def force(p: CoriolisForce, velocity: float, rotation: float) -> float:
    """Coriolis force."""
    twice = 2.0 * p.mass * rotation * velocity
    return twice if p.positive else -twice
