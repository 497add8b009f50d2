"""Rotation of a plane vector: x = first cos(angle) - second sin(angle), y = first sin(angle) + second cos(angle).

The inverse of Park's transform (Park, Two-reaction theory of synchronous machines, Trans. AIEE 48, 1929); with
minus the angle it is the transform itself.
"""

from proofmass.blocks.arithmetic.elementary import cosine, sine
from proofmass.blocks.declaration.declare import Block, Input, param


class VectorRotation(Block):
    """Turns a pair of signals by an angle: from axes that turn with a pattern, a rotor, a shaft, to those at rest."""

    unit: str = param("", "Unit of the components.", default="1")

    first = Input("{unit}", "Component along the turned first axis.", default=0.0)
    second = Input("{unit}", "Component along the turned second axis.", default=0.0)
    angle = Input("rad", "Angle of the turned axes.")


@VectorRotation.output("{unit}")
def along_x(p: VectorRotation, first: float, second: float, angle: float) -> float:
    """Component along the first axis at rest."""
    return first * cosine(angle) - second * sine(angle)


@VectorRotation.output("{unit}")
def along_y(p: VectorRotation, first: float, second: float, angle: float) -> float:
    """Component along the second axis at rest."""
    return first * sine(angle) + second * cosine(angle)
