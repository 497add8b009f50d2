"""Magnetoresistive angle bridge: voltage = supply ((g1 - g2) / (g1 + g2) + imbalance), g = 1 + ratio cos.

The free layers point along the field, at the angle d from the references. A reference layer points
along the sum of the field that holds it, Br, and of B: in arms 1 and 2, held in opposite
directions, cos is (e + cos d) / sqrt(1 + 2 e cos d + e^2) and (e - cos d) / sqrt(1 - 2 e cos d +
e^2), e = B / Br. Conductances after Slonczewski, Phys. Rev. B 39, 1989. To first order in e the
voltage is supply ratio (cos d - ratio e cos d sin^2 d): a third harmonic ratio e / 4.
"""

import math

from proofmass.blocks.arithmetic.elementary import cosine
from proofmass.blocks.declaration.declare import Block, Input, param


class MagnetoresistiveAngleBridge(Block):
    """Bridge of tunnel or giant magnetoresistors in a field that saturates them: the cosine of the field's angle."""

    ratio: float = param(
        "1",
        "Relative change of conductance from a right angle to parallel layers, TMR / (2 + TMR).",
        default=0.4,
        above=0.0,
        below=1.0,
    )
    direction: float = param("rad", "Direction of the reference layers of the first arms.", default=0.0)
    reference_field: float = param("T", "Br, field that holds the reference layers, above B.", default=0.6, above=0.0)
    imbalance: float = param("1", "Mean output over a turn, relative to the supply.", default=0.0)

    angle = Input("rad", "Direction of the field in the plane of the layers.")
    field = Input("T", "Magnetic flux density in that plane, B.")
    supply = Input("V", "Voltage across the bridge.")


def aligned(along: float, pull: float) -> float:
    """Cosine of a free layer and a reference, `along` apart until the field pulls the reference."""
    length = math.sqrt(1.0 + 2.0 * pull * along + pull * pull)
    return (pull + along) / length if length > 0.0 else 0.0


@MagnetoresistiveAngleBridge.output("V")
def voltage(p: MagnetoresistiveAngleBridge, angle: float, field: float, supply: float) -> float:
    """Voltage across the diagonal."""
    along, pull = cosine(angle - p.direction), field / p.reference_field
    first, second = 1.0 + p.ratio * aligned(along, pull), 1.0 + p.ratio * aligned(-along, pull)
    return supply * ((first - second) / (first + second) + p.imbalance)
