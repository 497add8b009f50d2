"""AC bridge: v = v_in (1/2 + (C1 - C2) / (2 (C1 + C2 + Cp)) - r), r = C_ref1 / (C_ref1 + C_ref2).

Without stray capacitance that is v_in (C1 / (C1 + C2) - r) (digital quartz accelerometer, section
II.B.3, eq. 4 and 5; with the plate attached to the first fixed one, eq. 16). The bridge has no
memory: the voltages may be those of the carrier from sample to sample, or its amplitude.
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class CapacitanceBridge(Block):
    """Bridge of two capacitors and two reference capacitors; its diagonal voltage."""

    first_reference: float = param("F", "Reference capacitor opposite the first.", default=42.590865e-12, above=0.0)
    second_reference: float = param("F", "Reference capacitor opposite the second.", default=42.409135e-12, above=0.0)
    stray: float = param("F", "Stray capacitance from the moving plate to ground.", default=0.0, at_least=0.0)

    first = Input("F", "Capacitance to the first plate, C1.")
    second = Input("F", "Capacitance to the second plate, C2.")
    excitation = Input("V", "Carrier across the bridge, or its amplitude.")


class Constants(NamedTuple):
    balance: float  # 1/2 - r
    stray: float


@CapacitanceBridge.constants
def constants(p: CapacitanceBridge, period: float) -> Constants:
    return Constants(0.5 - p.first_reference / (p.first_reference + p.second_reference), p.stray)


@CapacitanceBridge.output("V")
def voltage(c: Constants, first: float, second: float, excitation: float) -> float:
    """Voltage across the diagonal, or its amplitude."""
    return excitation * (c.balance + 0.5 * (first - second) / (first + second + c.stray))
