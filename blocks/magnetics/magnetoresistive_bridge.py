"""Magnetoresistive bridge: voltage = supply (ratio m + imbalance), m = B / sqrt(B^2 + Bk^2).

Opposite arms have conductances G (1 + ratio m) and G (1 - ratio m): a free layer whose hard axis lies in the field B
turns by asin(m). About zero it is supply ratio B / Bk (Freitas et al., Magnetoresistive sensors, J. Phys.: Condens.
Matter 19, 2007).
"""

import math

from proofmass.blocks.declaration.declare import Block, Input, param


class MagnetoresistiveBridge(Block):
    """Bridge of tunnel or giant magnetoresistors, which saturates softly: its range is its saturation field."""

    ratio: float = param("1", "Relative change of conductance to saturation.", default=0.4, above=0.0, below=1.0)
    saturation: float = param("T", "Field Bk of the free layer.", default=5e-3, above=0.0)
    imbalance: float = param("1", "Output without a field, relative to the supply.", default=0.0)

    field = Input("T", "Magnetic flux density along the sensitive axis, B.")
    supply = Input("V", "Voltage across the bridge.")


@MagnetoresistiveBridge.output("V")
def voltage(p: MagnetoresistiveBridge, field: float, supply: float) -> float:
    """Voltage across the diagonal."""
    part = field / p.saturation
    return supply * (p.ratio * part / math.sqrt(1.0 + part * part) + p.imbalance)
