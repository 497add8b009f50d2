"""Inertial force on a proof mass with cross-axis errors: F = -m (a + s1 b + s2 c + k2 a^2 + k12 a b + k13 a c).

a is the acceleration along the sensing axis, b and c those across it. s are angles of the axis, k2
the second-order coefficient, k12 and k13 cross-coupling coefficients (IEEE Std 1293, model
equation), in s^2/m: divide those per g by g.
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class CrossAxisMass(Block):
    """Force of acceleration on a MassSpringDamper whose axis leans and bends."""

    mass: float = param("kg", "Proof mass, m.", default=50.43e-9, above=0.0)
    first_sensitivity: float = param("1", "Part of the first cross acceleration that is sensed, s1.", default=0.0)
    second_sensitivity: float = param("1", "Part of the second cross acceleration that is sensed, s2.", default=0.0)
    second_order: float = param("s^2/m", "k2.", default=0.0)
    first_coupling: float = param("s^2/m", "k12.", default=0.0)
    second_coupling: float = param("s^2/m", "k13.", default=0.0)

    along = Input("m/s^2", "Acceleration along the sensing axis, a.")
    first_across = Input("m/s^2", "First acceleration across it, b.", default=0.0)
    second_across = Input("m/s^2", "Second acceleration across it, c.", default=0.0)


@CrossAxisMass.output("N")
def force(p: CrossAxisMass, along: float, first_across: float, second_across: float) -> float:
    """Force on the proof mass, seen from the case."""
    bent = along * (p.second_order * along + p.first_coupling * first_across + p.second_coupling * second_across)
    return -p.mass * (along + p.first_sensitivity * first_across + p.second_sensitivity * second_across + bent)
