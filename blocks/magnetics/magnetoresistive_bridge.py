"""Magnetoresistive bridge: voltage = supply (ratio m + imbalance), m = B / sqrt(B^2 + Bk^2).

Opposite arms have conductances G (1 + ratio m) and G (1 - ratio m): a free layer that a field Bk
across B biases turns to the sum of both, by asin(m). ratio is half of the whole change: TMR / (2 +
TMR), with the TMR of data sheets between antiparallel and parallel layers over the lower
resistance. About zero it is supply ratio B / Bk (Freitas et al., Magnetoresistive sensors, J.
Phys.: Condens. Matter 19, 2007).
"""

import math

from proofmass.blocks.declaration.declare import Block, Input, param


class MagnetoresistiveBridge(Block):
    """Bridge of tunnel or giant magnetoresistors, which saturates softly: its range is its saturation field."""

    ratio: float = param(
        "1",
        "Relative change of conductance from zero to saturation: 0.4 at a TMR of 133 %.",
        default=0.4,
        above=0.0,
        below=1.0,
    )
    saturation: float = param(
        "T", "Bias field Bk of the free layer: at Bk the output has 71 % of its limit.", default=5e-3, above=0.0
    )
    imbalance: float = param("1", "Output without a field, relative to the supply.", default=0.0)

    field = Input("T", "Magnetic flux density along the sensitive axis, B.")
    supply = Input("V", "Voltage across the bridge.")


@MagnetoresistiveBridge.output("V")
def voltage(p: MagnetoresistiveBridge, field: float, supply: float) -> float:
    """Voltage across the diagonal."""
    part = field / p.saturation
    return supply * (p.ratio * part / math.sqrt(1.0 + part * part) + p.imbalance)
