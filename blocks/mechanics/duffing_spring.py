"""Nonlinear spring: F = -(linear x + quadratic x^2 + cubic x^3) (Nayfeh and Mook, Nonlinear Oscillations, 1979).

A mass on k x + cubic x^3 swings at w0 (1 + 3 cubic A^2 / (8 k)) for a small amplitude A: it hardens
where cubic > 0.
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class DuffingSpring(Block):
    """Restoring force beyond Hooke's law, beside the stiffness of a MassSpringDamper: stretched or bent beams."""

    linear: float = param("N/m", "Stiffness in addition to that of the suspension.", default=0.0)
    quadratic: float = param("N/m^2", "Stiffness of second order: unlike for both directions.", default=0.0)
    cubic: float = param("N/m^3", "Stiffness of third order.", default=1.0e11)

    displacement = Input("m", "Displacement from rest.")


@DuffingSpring.output("N")
def force(p: DuffingSpring, displacement: float) -> float:
    """Force on the mass."""
    return -(p.linear + (p.quadratic + p.cubic * displacement) * displacement) * displacement
